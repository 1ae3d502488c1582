/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where a thing of known shape and orientation stands before the camera.
 */
#ifndef LT_GEOMETRY_TRANSLATION_H
#define LT_GEOMETRY_TRANSLATION_H

#include "libtensor/geometry/camera.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * lt_hand_translation - the t for which X + t is seen at uv: weighted linear least squares
 *
 *   X        (n, 3) metres, camera axes, e.g. joints relative to the wrist
 *   uv       (n, 2) pixels
 *   weight   (n) not negative, e.g. the peaks of heat maps; NULL: all the same
 *   t        (3) metres; touched only on success
 *
 * Minimises the sum of w (fx (X + tx) - (u - cx) (Z + tz))^2 and its twin in y, which is the reprojection
 * error times depth, so that three unknowns solve it at once.
 *
 * Errors: LT_EINVAL for n < 2, a number that is not finite, a negative weight or a focal length that is
 * not positive. LT_ENUMERIC when the depth is not determined (all of uv in one place) or a point that has
 * weight would not stand in front of the camera.
 */
LT_API lt_status lt_hand_translation(const lt_camera *cam, int n, const double *X, const double *uv,
                                     const double *weight, double t[3]);

/* lt_hand_translation_at - the same where the depth t[2] is known: t[0] and t[1] alone are sought, for which one point
 * is enough */
LT_API lt_status lt_hand_translation_at(const lt_camera *cam, int n, const double *X, const double *uv,
                                        const double *weight, double depth, double t[3]);

#ifdef __cplusplus
}
#endif
#endif
