/* SPDX-License-Identifier: Apache-2.0 */
/* The hand layer's formula, plainly, in double. */
#include "libtensor/geometry/hand/layer.h"

#include "libtensor/geometry/hand/chain.h"
#include "libtensor/geometry/mat3.h"

enum { V = LT_HAND_VERTICES, J = LT_HAND_JOINTS };

/* v = v_template + shapedirs beta */
static void shape_vertex(const lt_hand_model *m, int i, const double *beta, double v[3])
{
    for (int a = 0; a < 3; a++) {
        v[a] = m->v_template[i][a];
        for (int k = 0; k < LT_HAND_BETAS; k++)
            v[a] += m->shapedirs[i][a][k] * beta[k];
    }
}

/* rest = J_regressor v */
static void rest_joints(const lt_hand_model *m, double v[V][3], double rest[J][3])
{
    memset(rest, 0, sizeof(double[J][3]));
    for (int j = 0; j < J; j++)
        for (int i = 0; i < V; i++)
            for (int a = 0; a < 3; a++)
                rest[j][a] += m->J_regressor[j][i] * v[i][a];
}

/* The 135 numbers R_k - I of the fingers' rotations */
static void pose_feature(const double *R, double feature[LT_HAND_POSE_FEATURES])
{
    for (int k = 0; k < LT_HAND_POSE_FEATURES; k++)
        feature[k] = R[9 + k] - (k % 9 % 4 == 0);
}

void lt_hand_chain(double rest[J][3], const double *R, const double wrist[3], double world_R[J][9],
                   double world_t[J][3])
{
    memcpy(world_R[0], R, sizeof(world_R[0]));
    memcpy(world_t[0], wrist, sizeof(world_t[0]));
    for (int k = 1; k < J; k++) {
        const int parent = lt_hand_parent[k];
        double bone[3];
        lt_vec3_sub(rest[k], rest[parent], bone);
        lt_mat3_mul(world_R[parent], R + 9 * k, world_R[k]);
        lt_rigid_apply(world_R[parent], world_t[parent], bone, world_t[k]);
    }
}

/* v + posedirs feature, then the mean of the joints' motions weighted by w */
static void skin_vertex(const lt_hand_model *m, int i, const double *feature, double rest[J][3],
                        double world_R[J][9], double world_t[J][3], const double v[3], double out[3])
{
    double posed[3] = { v[0], v[1], v[2] };

    for (int a = 0; a < 3; a++)
        for (int k = 0; k < LT_HAND_POSE_FEATURES; k++)
            posed[a] += m->posedirs[i][a][k] * feature[k];
    out[0] = out[1] = out[2] = 0;
    for (int k = 0; k < J; k++) {
        double d[3], moved[3];
        lt_vec3_sub(posed, rest[k], d);
        lt_rigid_apply(world_R[k], world_t[k], d, moved);
        for (int a = 0; a < 3; a++)
            out[a] += m->weights[i][k] * moved[a];
    }
}

void lt_hand_pose(const lt_hand_model *model, const double *R, const double *beta, const double *trans,
                  double *vertices, double *joints)
{
    const double nowhere[3] = { 0 };
    const double *shift = trans ? trans : nowhere;
    double v[V][3], rest[J][3], world_R[J][9], world_t[J][3], feature[LT_HAND_POSE_FEATURES];

    for (int i = 0; i < V; i++)
        shape_vertex(model, i, beta, v[i]);
    rest_joints(model, v, rest);
    pose_feature(R, feature);
    lt_hand_chain(rest, R, rest[0], world_R, world_t);
    for (int i = 0; vertices && i < V; i++) {
        skin_vertex(model, i, feature, rest, world_R, world_t, v[i], vertices + 3 * i);
        for (int a = 0; a < 3; a++)
            vertices[3 * i + a] += shift[a];
    }
    for (int i = 0; joints && i < 3 * J; i++)
        joints[i] = world_t[i / 3][i % 3] + shift[i % 3];
}

void lt_hand_rest_wrist(const lt_hand_model *model, const double *beta, double J0[3])
{
    J0[0] = J0[1] = J0[2] = 0;
    for (int i = 0; i < V; i++) {
        double v[3];
        if (model->J_regressor[0][i] == 0)
            continue;
        shape_vertex(model, i, beta, v);
        for (int a = 0; a < 3; a++)
            J0[a] += model->J_regressor[0][i] * v[a];
    }
}

void lt_hand_keypoints(const double *vertices, const double *joints, const int tips[5],
                       lt_hand_order order, double *keypoints)
{
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const int mano = order == LT_HAND_SIMPLE_ORDER ? lt_mano_to_simple[i] : i;
        const double *from = mano < J ? joints + 3 * mano : vertices + 3 * tips[mano - J];
        memcpy(keypoints + 3 * i, from, 3 * sizeof(*from));
    }
}
