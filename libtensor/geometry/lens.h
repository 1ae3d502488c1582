/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lens distortion, as OpenCV calibrates it: where a pinhole camera's rays come to lie.
 *
 * Points are at depth 1 before the camera: (u - cx) / fx, (v - cy) / fy.
 */
#ifndef LT_GEOMETRY_LENS_H
#define LT_GEOMETRY_LENS_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LT_LENS_COEFFICIENTS = 8 };

/* All 0: no distortion. */
typedef struct {
    double k[6];                    /* k1 .. k6, radial: k4 to k6 divide */
    double p[2];                    /* p1 p2, tangential */
} lt_lens;

/**
 * lt_lens_from_opencv - n coefficients in OpenCV's order: k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]]
 *
 * Errors: LT_EINVAL when n is not 4, 5, 8, 12 or 14, one is not finite, or what describes a thin prism or a tilted
 * sensor (s, t) is not 0.
 */
LT_API lt_status lt_lens_from_opencv(const double *coefficient, int n, lt_lens *out);

/* lt_lens_to_opencv - the first eight of that order */
LT_API void lt_lens_to_opencv(const lt_lens *lens, double coefficient[LT_LENS_COEFFICIENTS]);

/* lt_lens_is_none - whether nothing is distorted */
LT_API bool lt_lens_is_none(const lt_lens *lens);

/* lt_lens_distort - where the lens puts a pinhole's point; out may be x */
LT_API void lt_lens_distort(const lt_lens *lens, const double x[2], double out[2]);

/* lt_lens_undistort - the pinhole's point of one that the lens made; false, and x itself, where none is found. out
 * may be x */
LT_API bool lt_lens_undistort(const lt_lens *lens, const double x[2], double out[2]);

/* lt_lens_fold - the distance from the axis, up to `farthest`, where points that lie farther out come no farther out:
 * coefficients describe no lens beyond it. Infinity when there is none. */
LT_API double lt_lens_fold(const lt_lens *lens, double farthest);

#ifdef __cplusplus
}
#endif
#endif
