/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The turns that leave an object of BOP's list as it is, by the geometric class of assets/ycb/ycb.h.
 */
#ifndef ASSETS_YCB_SYMMETRY_H
#define ASSETS_YCB_SYMMETRY_H

#include "assets/ycb/ycb.h"
#include "libtensor/geometry/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Steps of a continuous symmetry, as BOP has it: ceil(pi / 0.01) */
enum { YCB_TURNS = 315 };

/**
 * ycb_symmetries - model to model, the identity left out; their number
 *
 *   out      room for YCB_TURNS
 *
 * 0 for what is not of YCB_ADDS_BOP. All turn about axes through the centre of the model's box.
 */
int ycb_symmetries(const ycb_object *object, lt_pose *out);

/* ycb_turns_about - whether any turn is one, about which unit axis; ycb_symmetries has YCB_TURNS - 1 of them then */
bool ycb_turns_about(const ycb_object *object, double axis[3]);

#ifdef __cplusplus
}
#endif
#endif
