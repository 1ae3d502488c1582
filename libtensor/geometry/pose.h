/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where a rigid thing is: x_to = R x_from + t, in double.
 */
#ifndef LT_GEOMETRY_POSE_H
#define LT_GEOMETRY_POSE_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double R[9], t[3];              /* R by rows; t in metres */
} lt_pose;

/* lt_pose_apply - out (n, 3) = R x + t; out may not be x */
void lt_pose_apply(const lt_pose *pose, int n, const double *x, double *out);

/* lt_pose_of - the same pose in double */
lt_pose lt_pose_of(const float R[9], const float t[3]);

/* lt_pose_compose - x -> a(b(x)) */
lt_pose lt_pose_compose(const lt_pose *a, const lt_pose *b);

/* lt_pose_turn - a turn by angle (radians) about the unit axis through a point: x -> R (x - point) + point */
lt_pose lt_pose_turn(const double point[3], const double axis[3], double angle);

bool lt_pose_finite(const lt_pose *pose);

#ifdef __cplusplus
}
#endif
#endif
