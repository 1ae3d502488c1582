/* SPDX-License-Identifier: Apache-2.0 */
/* A hand is a rig whose points are its keypoints. */
#include "libtensor/geometry/hand/layer.h"

#include <string.h>

enum { V = LT_HAND_VERTICES, J = LT_HAND_JOINTS };

lt_rig lt_hand_rig(const lt_hand_model *m)
{
    return (lt_rig){
        .V = V, .J = J, .S = LT_HAND_BETAS, .parents = lt_hand_parent, .v_template = m->v_template[0],
        .shapedirs = m->shapedirs[0][0], .posedirs = m->posedirs[0][0], .J_regressor = m->J_regressor[0],
        .weights = m->weights[0],
    };
}

void lt_hand_pose(const lt_hand_model *model, const double *R, const double *beta, const double *trans,
                  double *vertices, double *joints)
{
    const lt_rig rig = lt_hand_rig(model);

    lt_rig_pose(&rig, R, beta, trans, vertices, joints);
}

void lt_hand_rest_wrist(const lt_hand_model *model, const double *beta, double J0[3])
{
    const lt_rig rig = lt_hand_rig(model);

    lt_rig_root(&rig, beta, J0);
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

lt_status lt_hand_layer_new(lt_arena *arena, const lt_hand_model *model, const int tips[5],
                            lt_hand_layer **out)
{
    const lt_rig rig = lt_hand_rig(model);
    int points[LT_HAND_KEYPOINTS];

    for (int i = 0; i < 5; i++)
        if (tips[i] < 0 || tips[i] >= V)
            return lt_error(LT_EINVAL, "hand layer: finger tip %d is vertex %d, want 0 to %d", i, tips[i],
                            V - 1);
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const int mano = lt_mano_to_simple[i];

        points[i] = mano < J ? mano : J + tips[mano - J];
    }
    return lt_skin_layer_new(arena, &rig, points, LT_HAND_KEYPOINTS, out);
}

void lt_hand_layer_tips(const lt_hand_layer *layer, int tips[5])
{
    const int *points = lt_skin_layer_tables(layer).points;

    for (int i = 0; i < 5; i++)
        tips[i] = points[lt_simple_to_mano[J + i]] - J;
}
