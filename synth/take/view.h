/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the cameras stand: so that the hand stays in the picture at a good size, and its arm does not hide it.
 */
#ifndef SYNTH_TAKE_VIEW_H
#define SYNTH_TAKE_VIEW_H

#include "libtensor/geometry/hand/model.h"
#include "synth/render/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a camera has to see at one moment; world axes. */
typedef struct {
    double keypoints[LT_HAND_KEYPOINTS][3];     /* MANO order */
    double elbow[3];                            /* unit direction from the wrist */
    double object[3];                           /* its centre */
} synth_sight;

/**
 * synth_view_choose - cameras for n moments
 *
 *   number       of the first camera in its dataset: hands before and behind objects are dealt in turn, so that
 *                every dataset has its share of both
 *   n_cameras    1 .. 8, at least 20 degrees apart as seen from the action
 *   out          640 x 480, intrinsics of their own each, in the room's viewing half
 *
 * The best of many draws: wrist 0.4 to 0.9 m away, the joints' box 90 to 260 pixels, its centre within
 * the middle 70 % of the picture. A function of (seed, stream, number) and the sights.
 */
void synth_view_choose(const synth_sight *sight, int n, uint64_t seed, uint64_t stream, int number,
                       int n_cameras, synth_camera *out);

/* synth_view_look - put a camera at eye: z at the target, x level but for the roll (radians) */
void synth_view_look(const double eye[3], const double target[3], double roll, synth_camera *out);

#ifdef __cplusplus
}
#endif
#endif
