/* SPDX-License-Identifier: Apache-2.0 */
/* Three numbers and their like. Written out, for fminf, fmaxf and floorf are calls on a plain x86-64, and
 * these are everywhere. */
#ifndef DATA_SYNTH_RENDER_SMALL_H
#define DATA_SYNTH_RENDER_SMALL_H

#include <math.h>

static inline float least(float a, float b) { return a < b ? a : b; }
static inline float most(float a, float b) { return a > b ? a : b; }
static inline float within(float x, float lo, float hi) { return x < lo ? lo : x > hi ? hi : x; }

/* Rounds down; |x| below 2^31. */
static inline int floor_int(float x)
{
    const int i = (int)x;

    return i - (x < (float)i);
}

static inline float dot3(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross3(const float a[3], const float b[3], float out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* To unit length; returns the length it had. A zero vector stays. */
static inline float normalise3(float v[3])
{
    const float n = sqrtf(dot3(v, v)), k = n > 0 ? 1 / n : 0;

    for (int i = 0; i < 3; i++)
        v[i] *= k;
    return n;
}

/* 0 below lo, 1 above hi, smooth between */
static inline float smoothly(float lo, float hi, float x)
{
    const float t = within((x - lo) / (hi - lo), 0, 1);

    return t * t * (3 - 2 * t);
}

#endif
