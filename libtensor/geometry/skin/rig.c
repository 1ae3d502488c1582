/* SPDX-License-Identifier: Apache-2.0 */
/* Linear blend skinning, plainly, in double. */
#include "libtensor/geometry/skin/rig.h"

#include "libtensor/geometry/mat3.h"

#include <assert.h>

/* v = v_template + shapedirs shape */
static void shape_vertex(const lt_rig *rig, int i, const double *shape, double v[3])
{
    for (int a = 0; a < 3; a++) {
        const float *directions = rig->shapedirs + (3 * (int64_t)i + a) * rig->S;

        v[a] = rig->v_template[3 * i + a];
        for (int k = 0; k < rig->S; k++)
            v[a] += directions[k] * shape[k];
    }
}

/* rest_j = J_regressor_j v, of the first n joints */
static void rest_joints(const lt_rig *rig, int n, const double *shape, double (*rest)[3])
{
    memset(rest, 0, (size_t)n * sizeof(*rest));
    for (int i = 0; i < rig->V; i++) {
        double v[3];
        bool shaped = false;

        for (int j = 0; j < n; j++) {
            const double w = rig->J_regressor[(int64_t)j * rig->V + i];

            if (w == 0)
                continue;
            if (!shaped)
                shape_vertex(rig, i, shape, v);
            shaped = true;
            for (int a = 0; a < 3; a++)
                rest[j][a] += w * v[a];
        }
    }
}

void lt_rig_root(const lt_rig *rig, const double *shape, double root[3])
{
    double rest[1][3];

    rest_joints(rig, 1, shape, rest);
    memcpy(root, rest[0], sizeof(rest[0]));
}

void lt_rig_chain(int J, const int *parents, const double (*rest)[3], const double *R, const double root[3],
                  double (*world_R)[9], double (*world_t)[3])
{
    memcpy(world_R[0], R, sizeof(world_R[0]));
    memcpy(world_t[0], root, sizeof(world_t[0]));
    for (int k = 1; k < J; k++) {
        const int parent = parents[k];
        double bone[3];

        lt_vec3_sub(rest[k], rest[parent], bone);
        lt_mat3_mul(world_R[parent], R + 9 * k, world_R[k]);
        lt_rigid_apply(world_R[parent], world_t[parent], bone, world_t[k]);
    }
}

/* Joints before posing, and their frames */
typedef struct {
    double rest[LT_RIG_JOINTS][3], world_R[LT_RIG_JOINTS][9], world_t[LT_RIG_JOINTS][3];
} skeleton;

/* The vertex with its shape and pose offsets, and then the mean of the joints' motions weighted by its weights */
static void skin_vertex(const lt_rig *rig, int i, const double *shape, const double *R, const skeleton *s,
                        double out[3])
{
    const int P = 9 * (rig->J - 1);
    double posed[3];

    shape_vertex(rig, i, shape, posed);
    for (int a = 0; rig->posedirs && a < 3; a++) {
        const float *directions = rig->posedirs + (3 * (int64_t)i + a) * P;

        for (int k = 0; k < P; k++)
            posed[a] += directions[k] * (R[9 + k] - (k % 9 % 4 == 0));
    }
    out[0] = out[1] = out[2] = 0;
    for (int k = 0; k < rig->J; k++) {
        const double w = rig->weights[(int64_t)i * rig->J + k];
        double d[3], moved[3];

        if (w == 0)
            continue;
        lt_vec3_sub(posed, s->rest[k], d);
        lt_rigid_apply(s->world_R[k], s->world_t[k], d, moved);
        for (int a = 0; a < 3; a++)
            out[a] += w * moved[a];
    }
}

void lt_rig_pose(const lt_rig *rig, const double *R, const double *shape, const double *trans, double *vertices,
                 double *joints)
{
    const double nowhere[3] = { 0 };
    const double *shift = trans ? trans : nowhere;
    skeleton s;

    assert(rig->J <= LT_RIG_JOINTS);
    rest_joints(rig, rig->J, shape, s.rest);
    lt_rig_chain(rig->J, rig->parents, s.rest, R, s.rest[0], s.world_R, s.world_t);
    for (int i = 0; vertices && i < rig->V; i++) {
        skin_vertex(rig, i, shape, R, &s, vertices + 3 * i);
        for (int a = 0; a < 3; a++)
            vertices[3 * i + a] += shift[a];
    }
    for (int i = 0; joints && i < 3 * rig->J; i++)
        joints[i] = s.world_t[i / 3][i % 3] + shift[i % 3];
}
