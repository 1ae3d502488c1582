/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Three numbers at a time.
 */
#ifndef SYNTH_GRASP_VEC_H
#define SYNTH_GRASP_VEC_H

#include <math.h>

static inline double dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross3(const double a[3], const double b[3], double out[3])
{
    const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2];

    out[2] = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
}

static inline void unit3(double a[3])
{
    const double n = sqrt(dot3(a, a));

    for (int k = 0; k < 3; k++)
        a[k] /= n;
}

/* out = R a, out = R^T a; out may be a */
static inline void turn3(const double R[9], const double a[3], double out[3])
{
    const double x = dot3(&R[0], a), y = dot3(&R[3], a);

    out[2] = dot3(&R[6], a);
    out[0] = x;
    out[1] = y;
}

static inline void mul33(const double A[9], const double B[9], double out[9])
{
    double C[9];

    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            C[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
    for (int i = 0; i < 9; i++)
        out[i] = C[i];
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
