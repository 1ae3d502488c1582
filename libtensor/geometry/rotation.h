/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rotations in three dimensions: matrix, axis-angle, quaternion and the 6 numbers that networks predict.
 *
 * A rotation is a row-major double R[9] that turns column vectors: y = R x. Axis-angle vectors point
 * along the axis and are as long as the angle in radians. Nothing here fails: input that is not a number
 * comes out as not a number.
 */
#ifndef LT_GEOMETRY_ROTATION_H
#define LT_GEOMETRY_ROTATION_H

#include "libtensor/geometry/mat3.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lt_rot_from_axis_angle - Rodrigues' formula, by series where the angle is small; 0 gives I exactly */
LT_API void lt_rot_from_axis_angle(const double aa[3], double R[9]);

/**
 * lt_rot_to_axis_angle - the shortest axis-angle vector of R, angle in [0, pi]
 *
 * Accurate at both ends: the way leads through the quaternion, which is well conditioned at 0 and at pi.
 * At pi exactly, where two axes are right, the one given has its largest component positive.
 */
LT_API void lt_rot_to_axis_angle(const double R[9], double aa[3]);

/* lt_rot_from_quat - R of the quaternion q = (w, x, y, z), of any length; a zero quaternion gives I */
LT_API void lt_rot_from_quat(const double q[4], double R[9]);

/* lt_rot_to_quat - the unit quaternion (w, x, y, z) of R, with w >= 0 */
LT_API void lt_rot_to_quat(const double R[9], double q[4]);

/* lt_quat_mul - out = a b: b turns first. out may be a or b */
LT_API void lt_quat_mul(const double a[4], const double b[4], double out[4]);

/* lt_quat_exp - the unit quaternion of the axis-angle vector scale v */
LT_API void lt_quat_exp(const double v[3], double scale, double q[4]);

/* lt_quat_difference - the axis-angle vector of a b^-1, the shorter way round: from unit b to unit a */
LT_API void lt_quat_difference(const double a[4], const double b[4], double v[3]);

/* lt_quat_unit - q at length 1, in place; false, and q of no use, where it is 0 or not finite */
LT_API bool lt_quat_unit(double q[4]);

/**
 * lt_rot_from_6d - the rotation that Gram-Schmidt makes of two vectors
 *
 *   d   a1 (3), a2 (3)
 *   R   columns b1 = a1/|a1|, b2 = (a2 - (b1.a2) b1)/|.|, b3 = b1 x b2
 *
 * Norms are held at 1e-12 from below, so that zeros and parallel vectors give finite numbers, though
 * then no rotation. (1,0,0, 0,1,0) is I.
 *
 * Source: Zhou et al. 2019, "On the continuity of rotation representations in neural networks".
 */
LT_API void lt_rot_from_6d(const double d[6], double R[9]);

/* lt_rot_to_6d - the first two columns of R, one after the other: what lt_rot_from_6d takes back to R */
LT_API void lt_rot_to_6d(const double R[9], double d[6]);

/* lt_rot_nearest - the rotation (determinant +1) closest to M in the Frobenius norm; M may be singular */
LT_API void lt_rot_nearest(const double M[9], double R[9]);

/* lt_rot_is_near - no element of M is further than tolerance from that rotation; false for a mirror, and for NaN */
LT_API bool lt_rot_is_near(const double M[9], double tolerance);

/* lt_rot_angle - the angle of A^T B in [0, pi]: how far one rotation is from the other, radians. Accurate
 * to 1e-15 near 0 as well, where the arc cosine of the trace would know only half the digits. */
LT_API double lt_rot_angle(const double A[9], const double B[9]);

#ifdef __cplusplus
}
#endif
#endif
