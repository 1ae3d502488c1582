/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Things that lie on the table of a take and stay there.
 */
#ifndef SYNTH_TAKE_SETTLE_H
#define SYNTH_TAKE_SETTLE_H

#include "libtensor/base/rng.h"
#include "synth/take/clearing.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where something stands: x_world = R x_model + t. */
typedef struct { double R[9], t[3]; } synth_settled;

/**
 * synth_settle - stand a mesh on the table, turned about the vertical, out of the way of n balls
 *
 *   ball     synth_settled_ball of what stands there already, and what moves
 *   out      the first of many draws that is clear, 0.15 to 0.45 m from the middle; with none, the farthest
 *
 * Returns whether it is clear.
 */
bool synth_settle(const lt_mesh *mesh, const synth_ball *ball, int n, lt_rng *rng, synth_settled *out);

/* synth_settled_ball - around it */
synth_ball synth_settled_ball(const lt_mesh *mesh, const synth_settled *at);

#ifdef __cplusplus
}
#endif
#endif
