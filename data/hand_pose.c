/* SPDX-License-Identifier: Apache-2.0 */
#include "data/hand_pose.h"

#include "libtensor/geometry/hand/layer.h"

void hand_pose_widen(const float *rotation, const float *beta, double *R, double *b)
{
    for (int i = 0; i < 9 * LT_HAND_JOINTS; i++)
        R[i] = rotation[i];
    for (int i = 0; i < LT_HAND_BETAS; i++)
        b[i] = beta[i];
}

void hand_pose_label(const lt_hand_model *hand, const float *rotation, const float *beta, double (*vertices)[3],
                     double (*joints)[3])
{
    double R[9 * LT_HAND_JOINTS], b[LT_HAND_BETAS];

    hand_pose_widen(rotation, beta, R, b);
    lt_hand_pose(hand, R, b, NULL, vertices[0], joints[0]);
}

void hand_pose_at(const lt_hand_model *hand, const float *rotation, const float *beta, const float root[3],
                  double (*vertices)[3])
{
    double joints[LT_HAND_JOINTS][3];

    hand_pose_label(hand, rotation, beta, vertices, joints);
    for (int v = 0; v < LT_HAND_VERTICES; v++)
        for (int k = 0; k < 3; k++)
            vertices[v][k] = vertices[v][k] - joints[0][k] + root[k];
}
