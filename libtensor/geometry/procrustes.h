/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The transformation that lays one point set on another whose points correspond: the alignments
 * behind the PA- metrics, and the rigid fit.
 *
 * Points are (n, 3), row by row, metres. All functions: x is moved onto y. Errors: LT_EINVAL for n < 1 or
 * for a coordinate that is not finite; the output is then untouched. Fewer than 3 points, or points
 * on a line, leave the rotation open; one of the best ones is given.
 */
#ifndef LT_GEOMETRY_PROCRUSTES_H
#define LT_GEOMETRY_PROCRUSTES_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* y = scale * R x + t */
typedef struct {
    double scale, R[9], t[3];
} lt_similarity;

/**
 * lt_procrustes_ho3d - the alignment of the HO3D, FreiHAND and DexYCB scoring scripts
 *
 * Both sets are centred and divided by (norm + 1e-8); R is the best orthogonal matrix, and so may be a
 * reflection. When all x are equal, the aligned points are all the mean of y.
 *
 * Source: shreyashampali/ho3d eval.py (align_w_scale).
 */
LT_API lt_status lt_procrustes_ho3d(int n, const double *x, const double *y, lt_similarity *out);

/**
 * lt_procrustes_umeyama - least squares over scale, rotation (determinant +1) and translation
 *
 * When all x are equal, scale is 0.
 *
 * Source: Umeyama 1991, "Least-squares estimation of transformation parameters between two point patterns".
 */
LT_API lt_status lt_procrustes_umeyama(int n, const double *x, const double *y, lt_similarity *out);

/* lt_procrustes_rigid - least squares over rotation (determinant +1) and translation; scale is 1 */
LT_API lt_status lt_procrustes_rigid(int n, const double *x, const double *y, lt_similarity *out);

/**
 * lt_align_scale_translation - HO3D's alignment without rotation
 *
 *   out = s (x - x[root]) + y[root],  s = |y[other] - y[root]| / |x[other] - x[root]|
 *
 * Joint `other` is 4, the middle finger's knuckle in MANO order, in HO3D's script; a divisor of 0 is taken
 * as 1, as there. out (n, 3) may be x. LT_EINVAL also when root or other is outside [0, n).
 */
LT_API lt_status lt_align_scale_translation(int n, const double *x, const double *y, int root, int other,
                                            double *out);

/* lt_similarity_apply - out = scale * R x + t for n points; out may be x */
LT_API void lt_similarity_apply(const lt_similarity *s, int n, const double *x, double *out);

#ifdef __cplusplus
}
#endif
#endif
