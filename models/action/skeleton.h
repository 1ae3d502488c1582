/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The graphs of joints that actions are told from: a body with hands, and a hand with an object.
 *
 * Source: Yan et al. 2018, "Spatial temporal graph convolutional networks for skeleton-based action recognition",
 * section 3.3.
 */
#ifndef MODELS_ACTION_SKELETON_H
#define MODELS_ACTION_SKELETON_H

#include "libtensor/ops/ops.h"

enum { SKELETON_BODY = 65, SKELETON_HAND_OBJECT = 30, SKELETON_SUBSETS = 3 };

/* skeleton_body - links by spatial configuration, in subsets: a joint itself; its neighbours that are farther from the
 * neck; and those that are nearer. A joint's links weigh 1 together. NULL without memory. */
const lt_adjacency *skeleton_body(lt_arena *arena);

/* skeleton_hand_object - wrist and fingers, the object's cuboid and its centre, which knows the wrist and the finger
 * tips; in one subset, weighed by 1 / sqrt(degree of either). NULL without memory. */
const lt_adjacency *skeleton_hand_object(lt_arena *arena);

#endif
