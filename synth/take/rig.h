/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Cameras on a stand around a table, as a lab has them: the same for everything that is filmed in a session.
 */
#ifndef SYNTH_TAKE_RIG_H
#define SYNTH_TAKE_RIG_H

#include "synth/render/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * synth_rig_new - n cameras, 1 to 8, on a ring 0.8 m from the table's middle, 0.3 to 0.7 m above it
 *
 *   session      where each stands and looks exactly; intrinsics are a function of seed and camera alone
 *   out          (n) 640 x 480, in the room's viewing half, from left to right, every other one low
 */
void synth_rig_new(uint64_t seed, int session, int n, synth_camera *out);

/* synth_rig_mirror - the same cameras in the mirror x -> -x, for a take that is filmed there; in place */
void synth_rig_mirror(synth_camera *camera, int n);

#ifdef __cplusplus
}
#endif
#endif
