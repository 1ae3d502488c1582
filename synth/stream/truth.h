/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What was drawn, as a sample has it.
 */
#ifndef SYNTH_STREAM_TRUTH_H
#define SYNTH_STREAM_TRUTH_H

#include "data/dataset.h"

#ifdef __cplusplus
extern "C" {
#endif

/* truth_hand - rotations about joints; joints: in MANO order, metres in the camera's frame */
void truth_hand(const double rotation[LT_HAND_JOINTS][9], const double beta[LT_HAND_BETAS],
                const double joints[LT_HAND_KEYPOINTS][3], dataset_sample *out);

/* truth_object - its number among the dataset's objects, its pose in the camera's frame */
void truth_object(int object, const double R[9], const double t[3], dataset_sample *out);

#ifdef __cplusplus
}
#endif
#endif
