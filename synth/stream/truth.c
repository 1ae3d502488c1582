/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/stream/truth.h"

#include <string.h>

void truth_hand(const double rotation[LT_HAND_JOINTS][9], const double beta[LT_HAND_BETAS],
                const double joints[LT_HAND_KEYPOINTS][3], dataset_sample *out)
{
    for (int i = 0; i < LT_HAND_JOINTS; i++)
        for (int k = 0; k < 9; k++)
            out->rotation[i][k] = (float)rotation[i][k];
    for (int k = 0; k < LT_HAND_BETAS; k++)
        out->beta[k] = (float)beta[k];
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        for (int k = 0; k < 3; k++)
            out->joints[i][k] = (float)joints[lt_mano_to_simple[i]][k];
    memcpy(out->root, out->joints[0], sizeof(out->root));
    out->flags |= SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT;
}

void truth_object(int object, const double R[9], const double t[3], dataset_sample *out)
{
    out->object = object;
    for (int k = 0; k < 9; k++)
        out->R[k] = (float)R[k];
    for (int k = 0; k < 3; k++)
        out->t[k] = (float)t[k];
    out->flags |= SAMPLE_OBJECT;
}
