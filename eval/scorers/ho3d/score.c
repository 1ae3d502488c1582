/* SPDX-License-Identifier: Apache-2.0 */
/* The official HO3D hand score: samples in parallel, sums in the order of the list. */
#include "eval/scorers/ho3d/score.h"

#include "eval/metrics/curve.h"
#include "eval/metrics/metrics.h"
#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/procrustes.h"
#include "libtensor/io/atomic_file.h"

#include <math.h>
#include <stdlib.h>

enum {
    J = LT_HAND_KEYPOINTS, V = LT_HAND_VERTICES,
    BONE_BASE = 0, BONE_TIP = 4,    /* wrist, middle MCP: what scale-translation measures by */
    BLOCK = 64,                     /* samples whose distances are held at once */
};

static const char *const score_names[HO3D_SCORES] = {
    "xyz_mean3d", "xyz_auc3d", "xyz_procrustes_al_mean3d", "xyz_procrustes_al_auc3d",
    "xyz_scale_trans_al_mean3d", "xyz_scale_trans_al_auc3d", "mesh_mean3d", "mesh_auc3d",
    "mesh_al_mean3d", "mesh_al_auc3d", "f_score_5", "f_al_score_5", "f_score_15", "f_al_score_15",
};

/* All distances of one sample, before they are counted. */
typedef struct {
    double xyz[J], xyz_pa[J], xyz_st[J], mesh[V], mesh_pa[V];
    eval_f f[2], f_al[2];           /* at 5 and 15 mm */
    bool finite;
    lt_status status;
} distances;

struct ho3d_scorer {
    eval_pck *xyz, *xyz_pa, *xyz_st, *mesh, *mesh_pa;
    double f[2], f_al[2];           /* sums */
    int64_t n, failed;
    bool other_mesh;                /* than MANO's: it has no errors by vertex */
    distances *block;               /* (BLOCK) */
};

ho3d_scorer *ho3d_scorer_new(void)
{
    ho3d_scorer *s = calloc(1, sizeof(*s));

    if (!s)
        return NULL;
    s->xyz = eval_pck_new(J, 0, .05, 100);
    s->xyz_pa = eval_pck_new(J, 0, .05, 100);
    s->xyz_st = eval_pck_new(J, 0, .05, 100);
    s->mesh = eval_pck_new(V, 0, .05, 100);
    s->mesh_pa = eval_pck_new(V, 0, .05, 100);
    s->block = lt_alloc(BLOCK * sizeof(*s->block));
    if (s->xyz && s->xyz_pa && s->xyz_st && s->mesh && s->mesh_pa && s->block)
        return s;
    ho3d_scorer_free(s);
    return NULL;
}

void ho3d_scorer_free(ho3d_scorer *s)
{
    if (!s)
        return;
    eval_pck_free(s->xyz);
    eval_pck_free(s->xyz_pa);
    eval_pck_free(s->xyz_st);
    eval_pck_free(s->mesh);
    eval_pck_free(s->mesh_pa);
    lt_release(s->block);
    free(s);
}

/* ---- one sample -------------------------------------------------------------------------- */

static void measure_joints(const float *p32, const float *g32, distances *d)
{
    double p[3 * J], g[3 * J], aligned[3 * J];

    eval_widen(3 * J, p32, p);
    eval_widen(3 * J, g32, g);
    d->finite = lt_all_finite(3 * J, p);
    eval_distances(J, p, g, d->xyz);
    eval_align_procrustes(EVAL_REFLECT, J, p, g, aligned);
    eval_distances(J, aligned, g, d->xyz_pa);
    eval_align_scale(J, p, g, BONE_BASE, BONE_TIP, aligned);
    eval_distances(J, aligned, g, d->xyz_st);
}

/* F at 5 and 15 mm of n points; d_p has room for as many numbers. */
static lt_status f_scores(int n, const double *p, const double *g, double *d_p, eval_f f[2])
{
    double d_g[V];
    const lt_status st = eval_nearest(n, p, V, g, d_p, d_g);

    if (st)
        return st;
    f[0] = eval_f_score(n, d_p, V, d_g, .005);
    f[1] = eval_f_score(n, d_p, V, d_g, .015);
    return LT_OK;
}

static void measure_mesh(const float *p32, const float *g32, distances *d)
{
    double p[3 * V], g[3 * V], aligned[3 * V], room[V];

    eval_widen(3 * V, p32, p);
    eval_widen(3 * V, g32, g);
    d->finite = d->finite && lt_all_finite(3 * V, p);
    eval_distances(V, p, g, d->mesh);
    eval_align_procrustes(EVAL_REFLECT, V, p, g, aligned);
    eval_distances(V, aligned, g, d->mesh_pa);
    d->status = f_scores(V, p, g, room, d->f);
    if (!d->status)
        d->status = f_scores(V, aligned, g, room, d->f_al);
}

/* What the script makes of n points by the similarity of the joints: about their own middle, by a scale that lacks the
 * division by the predicted joints' size (align_by_trafo). */
static void align_by_joints(const double *p_xyz, const double *g_xyz, int n, const double *p, double *out)
{
    double mp[3] = { 0 }, mj[3] = { 0 }, mg[3] = { 0 }, size = 0;
    lt_similarity fit;

    for (int i = 0; i < 3 * n; i++)
        mp[i % 3] += p[i] / n;
    for (int i = 0; i < 3 * J; i++) {
        mj[i % 3] += p_xyz[i] / J;
        mg[i % 3] += g_xyz[i] / J;
    }
    for (int i = 0; i < 3 * J; i++)
        size += (p_xyz[i] - mj[i % 3]) * (p_xyz[i] - mj[i % 3]);
    if (lt_procrustes_ho3d(J, p_xyz, g_xyz, &fit))
        fit = (lt_similarity){ NAN, { 0 }, { 0 } };
    fit.scale *= sqrt(size) + 1e-8;
    for (int i = 0; i < n; i++) {
        const double c[3] = { p[3 * i] - mp[0], p[3 * i + 1] - mp[1], p[3 * i + 2] - mp[2] };
        for (int k = 0; k < 3; k++)
            out[3 * i + k] = fit.scale * lt_vec3_dot(fit.R + 3 * k, c) + mg[k] - mj[k] + mp[k];
    }
}

static void measure_other_mesh(const float *p_xyz32, const float *p32, int n, const float *g_xyz32, const float *g32,
                               distances *d)
{
    double g[3 * V], p_xyz[3 * J], g_xyz[3 * J];
    double *p = malloc((size_t)(n + 1) * 7 * sizeof(*p)), *aligned = p + 3 * n, *room = aligned + 3 * n;

    if (!p) {
        d->status = LT_ENOMEM;
        return;
    }
    eval_widen(3 * V, g32, g);
    eval_widen(3 * J, p_xyz32, p_xyz);
    eval_widen(3 * J, g_xyz32, g_xyz);
    eval_widen(3 * n, p32, p);
    d->finite = d->finite && lt_all_finite(3 * n, p);
    align_by_joints(p_xyz, g_xyz, n, p, aligned);
    d->status = f_scores(n, p, g, room, d->f);
    if (!d->status)
        d->status = f_scores(n, aligned, g, room, d->f_al);
    free(p);
}

/* A failed prediction earns nothing, not even by its finite vertices. */
static void void_f_scores(distances *d)
{
    for (int k = 0; k < 2; k++)
        d->f[k] = d->f_al[k] = (eval_f){ 0 };
}

typedef struct {
    const float *p_xyz, *p_verts, *g_xyz, *g_verts;
    int points;                     /* of p_verts */
    distances *out;
} job;

static void measure(void *ctx, int64_t i)
{
    const job *j = ctx;
    distances *d = &j->out[i];

    measure_joints(j->p_xyz + i * 3 * J, j->g_xyz + i * 3 * J, d);
    if (j->points == V)
        measure_mesh(j->p_verts + i * 3 * V, j->g_verts + i * 3 * V, d);
    else
        measure_other_mesh(j->p_xyz + i * 3 * J, j->p_verts + i * 3 * j->points, j->points, j->g_xyz + i * 3 * J,
                           j->g_verts + i * 3 * V, d);
    if (!d->finite)
        void_f_scores(d);
}

/* ---- all samples ------------------------------------------------------------------------- */

static ho3d_sample_errors summarise(const distances *d)
{
    return (ho3d_sample_errors){
        .xyz = eval_mean(J, d->xyz), .xyz_pa = eval_mean(J, d->xyz_pa),
        .xyz_st = eval_mean(J, d->xyz_st),
        .mesh = eval_mean(V, d->mesh), .mesh_pa = eval_mean(V, d->mesh_pa),
        .f5 = d->f[0].f, .f_al5 = d->f_al[0].f, .f15 = d->f[1].f, .f_al15 = d->f_al[1].f,
    };
}

static void count(ho3d_scorer *s, const distances *d)
{
    eval_pck_add(s->xyz, d->xyz);
    eval_pck_add(s->xyz_pa, d->xyz_pa);
    eval_pck_add(s->xyz_st, d->xyz_st);
    if (!s->other_mesh) {
        eval_pck_add(s->mesh, d->mesh);
        eval_pck_add(s->mesh_pa, d->mesh_pa);
    }
    for (int k = 0; k < 2; k++) {
        s->f[k] += d->f[k].f;
        s->f_al[k] += d->f_al[k].f;
    }
    s->n++;
    s->failed += !d->finite;
}

static lt_status first_error(int64_t n, const distances *d)
{
    for (int64_t i = 0; i < n; i++) {
        if (d[i].status)
            return lt_error(d[i].status, "HO3D score: no memory for nearest neighbours");
    }
    return LT_OK;
}

static lt_status add(ho3d_scorer *s, int64_t n, const float *p_xyz, const float *p_verts, int points,
                     const float *g_xyz, const float *g_verts, ho3d_sample_errors *each)
{
    s->other_mesh = points != V;
    for (int64_t at = 0; at < n; at += BLOCK) {
        const int64_t m = lt_min_i64(BLOCK, n - at);
        job j = {
            .p_xyz = p_xyz + at * 3 * J, .p_verts = p_verts + at * 3 * points, .points = points,
            .g_xyz = g_xyz + at * 3 * J, .g_verts = g_verts + at * 3 * V, .out = s->block,
        };
        lt_status st;

        lt_parallel_for(m, measure, &j);
        st = first_error(m, s->block);
        if (st)
            return st;
        for (int64_t i = 0; i < m; i++) {
            count(s, &s->block[i]);
            if (each)
                each[at + i] = summarise(&s->block[i]);
        }
    }
    return LT_OK;
}

lt_status ho3d_scorer_add(ho3d_scorer *s, int64_t n, const float *p_xyz, const float *p_verts,
                          const float *g_xyz, const float *g_verts, ho3d_sample_errors *each)
{
    return add(s, n, p_xyz, p_verts, V, g_xyz, g_verts, each);
}

lt_status ho3d_scorer_add_mesh(ho3d_scorer *s, int64_t n, const float *p_xyz, const float *p_verts, int points,
                               const float *g_xyz, const float *g_verts)
{
    return add(s, n, p_xyz, p_verts, points, g_xyz, g_verts, NULL);
}

void ho3d_scorer_scores(const ho3d_scorer *s, double scores[HO3D_SCORES])
{
    const eval_pck *pck[] = { s->xyz, s->xyz_pa, s->xyz_st, s->mesh, s->mesh_pa };
    const double n = s->n > 0 ? (double)s->n : NAN;

    for (int k = 0; k < 5; k++) {
        scores[2 * k] = 100 * eval_pck_mean(pck[k]);
        scores[2 * k + 1] = eval_pck_auc(pck[k]);
    }
    if (s->other_mesh) {
        scores[HO3D_MESH_MEAN] = scores[HO3D_MESH_PA_MEAN] = -100;
        scores[HO3D_MESH_AUC] = scores[HO3D_MESH_PA_AUC] = -1;
    }
    for (int k = 0; k < 2; k++) {
        scores[HO3D_F_5 + 2 * k] = s->f[k] / n;
        scores[HO3D_F_AL_5 + 2 * k] = s->f_al[k] / n;
    }
}

int64_t ho3d_scorer_failed(const ho3d_scorer *s)
{
    return s->failed;
}

/* ---- out and in -------------------------------------------------------------------------- */

void ho3d_print_scores(FILE *f, const double scores[HO3D_SCORES])
{
    for (int i = 0; i < HO3D_SCORES; i++)
        fprintf(f, "%s: %f\n", score_names[i], scores[i]);
}

lt_status ho3d_write_scores(const char *path, const double scores[HO3D_SCORES])
{
    lt_atomic_file f;
    const lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    ho3d_print_scores(f.stream, scores);
    return lt_atomic_commit(&f);
}

/* diag(1, -1, -1): OpenCV to OpenGL */
static void flip(const float x[3], float out[3])
{
    out[0] = x[0];
    out[1] = -x[1];
    out[2] = -x[2];
}

void ho3d_joints_from_camera(const float *joints, float *out)
{
    for (int i = 0; i < J; i++)
        flip(joints + 3 * lt_simple_to_mano[i], out + 3 * i);
}

void ho3d_vertices_from_camera(const float *vertices, float *out)
{
    for (int i = 0; i < V; i++)
        flip(vertices + 3 * i, out + 3 * i);
}
