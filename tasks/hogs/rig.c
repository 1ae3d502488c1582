/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hogs/rig.h"

#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/surface.h"

#include <math.h>
#include <string.h>

static const double PADDING = 0.1;              /* of a box, on each side, of its extents */
static const double PALM[3] = { 0, -1, 0 };     /* where a flat right hand's palm looks */

static lt_status make_mesh(lt_arena *arena, const lt_hand_model *hand, const double (*vertex)[3], lt_mesh *out)
{
    *out = (lt_mesh){
        .n_vertices = LT_HAND_VERTICES, .n_faces = LT_HAND_FACES,
        .vertex = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*out->vertex)),
        .normal = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*out->normal)),
        .face = (int32_t (*)[3])hand->faces,
    };
    if (!out->vertex || !out->normal)
        return lt_error(LT_ENOMEM, "no memory for a hand's mesh");
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        for (int k = 0; k < 3; k++)
            out->vertex[i][k] = (float)vertex[i][k];
    lt_mesh_normals(out, out->normal);
    return LT_OK;
}

static void make_zones(hogs_rig *r, const int tips[5])
{
    contact_template t = {
        .n = LT_HAND_VERTICES, .vertex = (const float (*)[3])r->mesh.vertex,
        .normal = (const float (*)[3])r->mesh.normal, .weight = r->model->weights,
        .palm = { PALM[0], PALM[1], PALM[2] },
    };

    memcpy(t.tip, tips, sizeof(t.tip));
    contact_zones(&t, r->zone);
}

lt_status hogs_rig_new(lt_arena *arena, const lt_hand_model *hand, const int tips[5], const float *beta,
                       hogs_rig *out)
{
    double R[LT_HAND_JOINTS][9], vertex[LT_HAND_VERTICES][3], shape[LT_HAND_BETAS];
    lt_status st;

    *out = (hogs_rig){ .model = hand };
    for (int i = 0; i < LT_HAND_JOINTS; i++)
        lt_mat3_identity(R[i]);
    for (int k = 0; k < LT_HAND_BETAS; k++)
        shape[k] = (double)beta[k];
    lt_hand_pose(hand, &R[0][0], shape, NULL, &vertex[0][0], &out->joint[0][0]);
    st = make_mesh(arena, hand, (const double (*)[3])vertex, &out->mesh);
    if (st)
        return st;
    make_zones(out, tips);
    return lt_kd_tree_new(LT_HAND_VERTICES, &vertex[0][0], &out->vertices);
}

void hogs_rig_free(hogs_rig *r)
{
    lt_kd_tree_free(&r->vertices);
}

hogs_set hogs_rig_set(const hogs_rig *r, int id, const float *beta)
{
    hogs_set s = { .id = id, .lo = { INFINITY, INFINITY, INFINITY }, .hi = { -INFINITY, -INFINITY, -INFINITY },
                   .mesh = &r->mesh };

    for (int i = 0; i < r->mesh.n_vertices; i++)
        for (int k = 0; k < 3; k++) {
            s.lo[k] = fmin(s.lo[k], (double)r->mesh.vertex[i][k]);
            s.hi[k] = fmax(s.hi[k], (double)r->mesh.vertex[i][k]);
        }
    for (int k = 0; k < 3; k++) {
        const double pad = PADDING * (s.hi[k] - s.lo[k]);

        s.lo[k] -= pad;
        s.hi[k] += pad;
    }
    memcpy(s.beta, beta, sizeof(s.beta));
    return s;
}

/* ---- posed ----------------------------------------------------------------------------------------------- */

/* G_i = G_parent [R_i | J_i - J_parent], B_i = G_i Translate(-J_i), and the wrist from its place at rest to root */
void hogs_rig_bones(const hogs_rig *r, const float *rotation, const float root[3], hogs_bone out[LT_HAND_JOINTS])
{
    double R[LT_HAND_JOINTS][9], at[LT_HAND_JOINTS][3];

    for (int i = 0; i < LT_HAND_JOINTS; i++) {
        const int parent = lt_hand_parent[i];
        double own[9], step[3], turned[3];

        for (int k = 0; k < 9; k++)
            own[k] = (double)rotation[9 * i + k];
        if (parent < 0) {
            memcpy(R[i], own, sizeof(own));
            for (int k = 0; k < 3; k++)
                at[i][k] = (double)root[k];
        } else {
            lt_mat3_mul(R[parent], own, R[i]);
            lt_vec3_sub(r->joint[i], r->joint[parent], step);
            lt_mat3_mulvec(R[parent], step, turned);
            for (int k = 0; k < 3; k++)
                at[i][k] = at[parent][k] + turned[k];
        }
        lt_mat3_mulvec(R[i], r->joint[i], turned);
        for (int k = 0; k < 3; k++) {
            memcpy(out[i] + 4 * k, R[i] + 3 * k, 3 * sizeof(double));
            out[i][4 * k + 3] = at[i][k] - turned[k];
        }
    }
}

void hogs_rig_blend(const hogs_rig *r, const hogs_bone bone[LT_HAND_JOINTS], int vertex, hogs_bone out)
{
    const float *w = r->model->weights[vertex];

    for (int k = 0; k < 12; k++) {
        out[k] = 0;
        for (int b = 0; b < LT_HAND_JOINTS; b++)
            out[k] += (double)w[b] * bone[b][k];
    }
}

/* ---- samples for the skinning field ---------------------------------------------------------------------- */

/* How much each corner of a triangle counts at a place in its plane: by the areas opposite */
static void barycentric(const lt_mesh *mesh, const int32_t face[3], const float place[3], double out[3])
{
    double corner[3][3], p[3], sum = 0;

    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
            corner[c][k] = (double)mesh->vertex[face[c]][k];
    for (int k = 0; k < 3; k++)
        p[k] = (double)place[k];
    for (int c = 0; c < 3; c++) {
        double a[3], b[3], normal[3];

        lt_vec3_sub(corner[(c + 1) % 3], p, a);
        lt_vec3_sub(corner[(c + 2) % 3], p, b);
        lt_vec3_cross(a, b, normal);
        sum += out[c] = lt_vec3_norm(normal);
    }
    for (int c = 0; c < 3; c++)
        out[c] = sum > 0 ? out[c] / sum : 1.0 / 3;
}

lt_status hogs_rig_samples(const hogs_rig *r, lt_rng *rng, int n, float (*place)[3],
                           float (*weight)[SKIN_FIELD_BONES])
{
    int *face = lt_alloc((size_t)n * sizeof(*face));
    lt_status st = face ? lt_mesh_sample(&r->mesh, rng, n, place, face)
                        : lt_error(LT_ENOMEM, "no memory for %d places on a hand", n);

    for (int i = 0; i < n && !st; i++) {
        const int32_t *f = r->mesh.face[face[i]];
        double share[3];

        barycentric(&r->mesh, f, place[i], share);
        for (int b = 0; b < SKIN_FIELD_BONES; b++)
            weight[i][b] = (float)(share[0] * (double)r->model->weights[f[0]][b]
                                   + share[1] * (double)r->model->weights[f[1]][b]
                                   + share[2] * (double)r->model->weights[f[2]][b]);
    }
    lt_release(face);
    return st;
}
