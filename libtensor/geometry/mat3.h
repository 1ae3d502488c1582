/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Vectors of 3 and 3 x 3 matrices, small enough to be inlined. Matrices are row-major double[9].
 * An output may not be one of the inputs unless the comment says so.
 */
#ifndef LT_GEOMETRY_MAT3_H
#define LT_GEOMETRY_MAT3_H

#include "libtensor/base/common.h"

#include <math.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

/* lt_all_finite - whether none of n numbers is infinite or NaN */
static inline bool lt_all_finite(int64_t n, const double *x)
{
    for (int64_t i = 0; i < n; i++)
        if (!isfinite(x[i]))
            return false;
    return true;
}

static inline double lt_vec3_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double lt_vec3_norm(const double a[3])
{
    return sqrt(lt_vec3_dot(a, a));
}

/* v at length 1, in place; the zero vector stays. Returns the length that v had. */
static inline double lt_vec3_unit(double v[3])
{
    const double n = lt_vec3_norm(v);

    for (int i = 0; i < 3; i++)
        v[i] /= n > 0 ? n : 1;
    return n;
}

/* out = a - b; out may be a or b */
static inline void lt_vec3_sub(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] - b[i];
}

static inline double lt_vec3_distance(const double a[3], const double b[3])
{
    double d[3];

    lt_vec3_sub(a, b, d);
    return lt_vec3_norm(d);
}

static inline void lt_vec3_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void lt_mat3_identity(double M[9])
{
    for (int i = 0; i < 9; i++)
        M[i] = i % 4 == 0;
}

/* out = A B; out may be A or B */
static inline void lt_mat3_mul(const double A[9], const double B[9], double out[9])
{
    double C[9];

    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            C[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
    memcpy(out, C, sizeof(C));
}

static inline void lt_mat3_transpose(const double A[9], double out[9])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[3 * j + i] = A[3 * i + j];
}

/* out = A x; out may be x */
static inline void lt_mat3_mulvec(const double A[9], const double x[3], double out[3])
{
    const double y0 = lt_vec3_dot(A, x), y1 = lt_vec3_dot(A + 3, x), y2 = lt_vec3_dot(A + 6, x);

    out[0] = y0;
    out[1] = y1;
    out[2] = y2;
}

static inline double lt_mat3_det(const double A[9])
{
    return A[0] * (A[4] * A[8] - A[5] * A[7]) - A[1] * (A[3] * A[8] - A[5] * A[6])
         + A[2] * (A[3] * A[7] - A[4] * A[6]);
}

/* whether R is a rotation: its columns of length 1 and upright on each other to `off`, and no mirror */
static inline bool lt_mat3_is_rotation(const double R[9], double off)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            const double dot = R[i] * R[k] + R[3 + i] * R[3 + k] + R[6 + i] * R[6 + k];

            if (!(fabs(dot - (i == k)) < off))
                return false;
        }
    return lt_mat3_det(R) > 0;
}

/* out = R x + t: from the object's frame to the camera's; out may be x */
static inline void lt_rigid_apply(const double R[9], const double t[3], const double x[3], double out[3])
{
    lt_mat3_mulvec(R, x, out);
    for (int i = 0; i < 3; i++)
        out[i] += t[i];
}

#ifdef __cplusplus
}
#endif
#endif
