/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Noise as large as HOISDF's errors (OCE 18.4 mm, MCE 27.4, ADD-S 13.3) for true poses to begin from.
 *
 * There are two levels that half of the draws have each: an object is off by 14.4 or 8.6 mm along each axis and by 15
 * or 9 degrees about it, a hand's joints by 8 or 4 degrees. Independent: drawn for each frame. Correlated: one draw for
 * a sequence and a tenth of another for each frame. Hands keep their wrist, which HOISDF is given.
 */
#ifndef DATA_POSES_POSE_NOISE_H
#define DATA_POSES_POSE_NOISE_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { POSE_NOISE_NONE, POSE_NOISE_INDEPENDENT, POSE_NOISE_CORRELATED } pose_noise_kind;

typedef struct { double hand[48], object[3], shift[3]; } pose_noise;    /* axis-angle, metres */

/* pose_noise_draw - of a frame; sequence and frame are the numbers of random streams, one for each of both */
pose_noise pose_noise_draw(pose_noise_kind kind, uint64_t seed, uint64_t sequence, uint64_t frame);

/* pose_noise_apply - to the pose (48, axis-angle) of a hand, and to R (9) and t (3) of an object, in place. A rotation
 * is turned about the camera's axes; angles of fingers are added to. */
void pose_noise_apply(const pose_noise *n, double pose[48], double R[9], double t[3]);

#ifdef __cplusplus
}
#endif
#endif
