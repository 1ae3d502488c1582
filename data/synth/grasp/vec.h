/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What libtensor/geometry/mat3.h does not have: products that may write over their inputs, turns about an axis.
 */
#ifndef SYNTH_GRASP_VEC_H
#define SYNTH_GRASP_VEC_H

#include "libtensor/geometry/mat3.h"

static inline void unit3(double a[3])
{
    const double n = lt_vec3_norm(a);

    for (int k = 0; k < 3; k++)
        a[k] /= n;
}

/* out = R a; out may be a */
static inline void turn3(const double R[9], const double a[3], double out[3])
{
    const double x = lt_vec3_dot(&R[0], a), y = lt_vec3_dot(&R[3], a);

    out[2] = lt_vec3_dot(&R[6], a);
    out[0] = x;
    out[1] = y;
}

/* out = A B; out may be either */
static inline void mul33(const double A[9], const double B[9], double out[9])
{
    double C[9];

    lt_mat3_mul(A, B, C);
    memcpy(out, C, sizeof(C));
}

/* The rotation by angle about a unit axis. */
static inline void axis_turn(const double a[3], double angle, double R[9])
{
    const double c = cos(angle), s = sin(angle), d = 1 - c;

    R[0] = c + d * a[0] * a[0];
    R[1] = d * a[0] * a[1] - s * a[2];
    R[2] = d * a[0] * a[2] + s * a[1];
    R[3] = d * a[1] * a[0] + s * a[2];
    R[4] = c + d * a[1] * a[1];
    R[5] = d * a[1] * a[2] - s * a[0];
    R[6] = d * a[2] * a[0] - s * a[1];
    R[7] = d * a[2] * a[1] + s * a[0];
    R[8] = c + d * a[2] * a[2];
}

#endif
