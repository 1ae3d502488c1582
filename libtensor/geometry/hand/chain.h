/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: the kinematic chain of the hand.
 */
#ifndef LT_GEOMETRY_HAND_CHAIN_H
#define LT_GEOMETRY_HAND_CHAIN_H

#include "libtensor/geometry/hand/model.h"

/* lt_hand_chain - frames of the 16 joints: world_R_k = world_R_parent R_k, and
 * world_t_k = world_t_parent + world_R_parent (rest_k - rest_parent); the wrist stands at `wrist`. */
void lt_hand_chain(double rest[LT_HAND_JOINTS][3], const double *R, const double wrist[3],
                   double world_R[LT_HAND_JOINTS][9], double world_t[LT_HAND_JOINTS][3]);

#endif
