/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A hand posed with a label: dataset_sample and hand_object_batch hold floats, lt_hand_pose takes doubles.
 *
 *   rotation    (16, 3, 3) row-major, in MANO's joint order, [0] turns the hand into the camera's axes
 *   beta        (10)
 *
 * Metres, camera axes.
 */
#ifndef DATA_HAND_POSE_H
#define DATA_HAND_POSE_H

#include "libtensor/geometry/hand/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* hand_pose_widen - the same numbers as doubles: R (16, 3, 3), b (10) */
void hand_pose_widen(const float *rotation, const float *beta, double *R, double *b);

/* hand_pose_label - vertices (778, 3) and joints (16, 3) of lt_hand_pose, which puts the wrist where it is at rest */
void hand_pose_label(const lt_hand_model *hand, const float *rotation, const float *beta, double (*vertices)[3],
                     double (*joints)[3]);

/* hand_pose_at - vertices (778, 3) with the wrist at root (3) */
void hand_pose_at(const lt_hand_model *hand, const float *rotation, const float *beta, const float root[3],
                  double (*vertices)[3]);

#ifdef __cplusplus
}
#endif
#endif
