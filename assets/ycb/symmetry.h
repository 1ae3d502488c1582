/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The turns that leave an object of BOP's list as it is, by the geometric class of assets/ycb/ycb.h.
 */
#ifndef ASSETS_YCB_SYMMETRY_H
#define ASSETS_YCB_SYMMETRY_H

#include "assets/ycb/ycb.h"
#include "eval/metrics/object_pose.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Steps of a continuous symmetry, as BOP has it: ceil(pi / 0.01) */
enum { EVAL_TURNS = 315 };

/* eval_turn - x -> R (x - point) + point, where R turns about a unit axis */
eval_pose eval_turn(const double point[3], const double axis[3], double angle);

/**
 * eval_symmetries - model to model, the identity left out; their number
 *
 *   out      room for EVAL_TURNS
 *
 * 0 for what is not in EVAL_SYM_BOP. All turn about axes through the centre of the model's box.
 */
int eval_symmetries(const ycb_object *object, eval_pose *out);

#ifdef __cplusplus
}
#endif
#endif
