/* SPDX-License-Identifier: Apache-2.0 */
/* Three numbers and their like. Written out, for fminf, fmaxf and floorf are calls on a plain x86-64, and
 * these are everywhere. Vectors by the compilers' common extension, so on any machine. */
#ifndef SYNTH_RENDER_SMALL_H
#define SYNTH_RENDER_SMALL_H

#include <math.h>
#include <stdint.h>

/* Four floats worked on at once; a point or a colour leaves the fourth unused. v4_at lies anywhere. */
typedef float v4 __attribute__((vector_size(16)));
typedef int32_t i32x4 __attribute__((vector_size(16)));
typedef float v4_at __attribute__((vector_size(16), aligned(4), may_alias));

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

static inline v4 v4_all(float x) { return (v4){ x, x, x, x }; }
static inline v4 v4_positive(v4 a) { return (v4)((i32x4)a & (a > v4_all(0))); }
static inline v4 v4_of3(const float p[3]) { return (v4){ p[0], p[1], p[2], 0 }; }
static inline float v4_sum3(v4 a) { return a[0] + a[1] + a[2]; }
static inline float v4_dot3(v4 a, v4 b) { return v4_sum3(a * b); }

static inline void v4_to3(v4 a, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i];
}

/* To unit length; returns the length it had. A zero vector stays. */
static inline float v4_normalise3(v4 *a)
{
    const float n = sqrtf(v4_dot3(*a, *a));

    *a *= v4_all(n > 0 ? 1 / n : 0);
    return n;
}

/* 0 below lo, 1 above hi, smooth between */
static inline float smoothly(float lo, float hi, float x)
{
    const float t = within((x - lo) / (hi - lo), 0, 1);

    return t * t * (3 - 2 * t);
}

#endif
