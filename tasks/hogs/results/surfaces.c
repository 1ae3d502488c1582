/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/results/surfaces.h"

#include "data/hand_pose.h"
#include "estimate/posed/posed.h"
#include "eval/metrics/shape.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/pose.h"
#include "tasks/hogs/results/shapes.h"

#include <string.h>

typedef struct {
    lt_arena *arena;
    const hogs_touch *truth;
    const hogs *m;
    const hogs_frame *f;
    const compiled *c;
    hogs_surface_scores *out;
} job;

/* The true hand, closed at the wrist: as the data have its vertices, else as its pose has it */
static lt_status true_hand(const job *j, lt_mesh *out)
{
    double (*at)[3] = lt_arena_array(j->arena, LT_HAND_VERTICES, sizeof(*at));
    float beta[LT_HAND_BETAS];

    *out = (lt_mesh){ .n_vertices = LT_HAND_VERTICES, .n_faces = EVAL_CLOSED_HAND_FACES,
                      .vertex = lt_arena_array(j->arena, LT_HAND_VERTICES, sizeof(*out->vertex)),
                      .face = (int32_t (*)[3])j->truth->face };
    if (!at || !out->vertex)
        return lt_error(LT_ENOMEM, "no memory for a hand");
    if (j->f->vertices) {
        memcpy(out->vertex, j->f->vertices, LT_HAND_VERTICES * sizeof(*out->vertex));
        return LT_OK;
    }
    hogs_beta(j->m, j->f->subject, beta);
    hand_pose_at(j->truth->hand, j->f->truth.rotation[0], beta, j->f->truth.root, at);
    for (int i = 0; i < 3 * LT_HAND_VERTICES; i++)
        out->vertex[i / 3][i % 3] = (float)at[i / 3][i % 3];
    return LT_OK;
}

static lt_status true_object(const job *j, lt_mesh *out)
{
    const lt_mesh *own = &j->truth->data->objects[j->f->data_object].mesh;
    const lt_pose pose = lt_pose_of(j->f->truth.R, j->f->truth.t);

    *out = (lt_mesh){ .n_vertices = own->n_vertices, .n_faces = own->n_faces, .face = own->face,
                      .vertex = lt_arena_array(j->arena, (size_t)own->n_vertices, sizeof(*out->vertex)) };
    if (!out->vertex)
        return lt_error(LT_ENOMEM, "no memory for an object");
    for (int i = 0; i < own->n_vertices; i++) {
        const double x[3] = { (double)own->vertex[i][0], (double)own->vertex[i][1], (double)own->vertex[i][2] };
        double y[3];

        lt_rigid_apply(pose.R, pose.t, x, y);
        for (int k = 0; k < 3; k++)
            out->vertex[i][k] = (float)y[k];
    }
    return LT_OK;
}

/* NULL vertices and LT_OK: there is no surface, which is counted. */
static lt_status surface_of(const job *j, bool object, lt_opacity_rule rule, lt_mesh *out)
{
    const double iso = rule == LT_OPACITY_MIN ? HOGS_ISO_MIN : POSED_ISO;
    const lt_status st = hogs_posed_mesh(j->arena, j->c, object, rule, iso, out);

    if (st != LT_EINVAL)
        return st;
    *out = (lt_mesh){ .vertex = NULL };
    j->out->failed++;
    return LT_OK;
}

/* Seen from a wrist */
static void move_by(lt_mesh *m, const float wrist[3])
{
    for (int i = 0; i < 3 * m->n_vertices; i++)
        m->vertex[i / 3][i % 3] -= wrist[i % 3];
}

static lt_status score_hand(const job *j)
{
    lt_mesh p, g;
    eval_shape_score s;
    lt_status st;

    if (!j->f->vertices && !j->f->hand_known)
        return LT_OK;
    st = surface_of(j, false, LT_OPACITY_MEAN, &p);
    if (st || !p.vertex)
        return st;
    st = true_hand(j, &g);
    if (st)
        return st;
    move_by(&p, j->f->initial.root);
    move_by(&g, j->f->truth.root);
    st = eval_shape(EVAL_AS_IT_IS, &p, &g, &s);
    if (!st) {
        j->out->model[HOGS_CD_H] = s.cd_cm2;
        j->out->model[HOGS_F_H_1] = s.f_1mm;
        j->out->model[HOGS_F_H_5] = s.f_5mm;
    }
    return st;
}

static lt_status put_object(eval_shape_alignment how, const lt_mesh *p, const lt_mesh *g, double out[HOGS_SCORES])
{
    eval_shape_score s;
    const lt_status st = eval_shape(how, p, g, &s);

    if (!st) {
        out[HOGS_CD_O] = s.cd_cm2;
        out[HOGS_F_O_5] = s.f_5mm;
        out[HOGS_F_O_10] = s.f_10mm;
    }
    return st;
}

static lt_status put_object_shapes(const job *j, const lt_mesh *p, const lt_mesh *g)
{
    lt_status st = put_object(EVAL_BY_SIMILARITY, p, g, j->out->model);

    if (!st)
        st = put_object(EVAL_WITHOUT_ROTATION, p, g, j->out->no_rotation);
    j->out->model[HOGS_CD_O_NOROT] = j->out->no_rotation[HOGS_CD_O];
    return st;
}

static lt_status put_vertices(const job *j, const lt_mesh *p, const lt_mesh *g)
{
    eval_shape_score s;
    const lt_status st = eval_shape_of_vertices(p, g, &s);

    if (!st) {
        j->out->model[HOGS_CD_O_VERTICES] = s.cd_cm2;
        j->out->model[HOGS_F_O_10_PERCENT] = 100 * s.f_10mm;
    }
    return st;
}

static lt_status score_object(const job *j, hogs_surfaces_wanted wanted, const lt_mesh *g)
{
    lt_mesh p;
    lt_status st = surface_of(j, true, LT_OPACITY_MEAN, &p);

    if (st || !p.vertex)
        return st;
    if (wanted.shapes)
        st = put_object_shapes(j, &p, g);
    if (!st && wanted.vertices)
        st = put_vertices(j, &p, g);
    if (!st && wanted.pose)
        st = eval_pose_chamfer_cm2(&p, j->f->initial.root, g, j->f->truth.root, &j->out->model[HOGS_CD_POSE]);
    return st;
}

static lt_status score_minimum(const job *j, const lt_mesh *g)
{
    lt_mesh p;
    const lt_status st = surface_of(j, true, LT_OPACITY_MIN, &p);

    return st || !p.vertex ? st : put_object(EVAL_BY_SIMILARITY, &p, g, j->out->minimum);
}

lt_status hogs_score_surfaces(const hogs_touch *truth, const hogs *m, const hogs_frame *f, const compiled *c,
                              hogs_surfaces_wanted wanted, hogs_surface_scores *out)
{
    const job j = { .arena = lt_arena_new(), .truth = truth, .m = m, .f = f, .c = c, .out = out };
    lt_mesh object;
    lt_status st;

    hogs_score_clear(out->model), hogs_score_clear(out->no_rotation), hogs_score_clear(out->minimum);
    out->failed = 0;
    if (!j.arena)
        return lt_error(LT_ENOMEM, "no memory for surfaces");
    st = true_object(&j, &object);
    if (!st && wanted.shapes)
        st = score_hand(&j);
    if (!st)
        st = score_object(&j, wanted, &object);
    if (!st && wanted.shapes)
        st = score_minimum(&j, &object);
    lt_arena_free(j.arena);
    return st;
}
