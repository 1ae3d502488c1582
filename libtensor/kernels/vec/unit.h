/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the units of the kernels need beside vectors. They are plain C, compiled once for each instruction set.
 */
#ifndef LT_KERNELS_VEC_UNIT_H
#define LT_KERNELS_VEC_UNIT_H

#include "libtensor/kernels/kernels.h"

#include <math.h>
#include <string.h>

#define INLINE static inline __attribute__((always_inline))

/* Before a static function that several units have a copy of, though not each of them calls it */
#define SHARED __attribute__((unused))

/* The next loop's iterations are independent, even where its pointers are equal. */
#ifdef __clang__
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define INDEPENDENT _Pragma("GCC ivdep")
#endif

#ifdef LT_DOUBLE
#define FMA(a, b, c) fma(a, b, c)
#define FABS fabs
#define FLOOR floor
#define CEIL ceil
#define LOG2 log2
#define SQRT sqrt
#define COPYSIGN copysign
#else
#define FMA(a, b, c) fmaf(a, b, c)
#define FABS fabsf
#define FLOOR floorf
#define CEIL ceilf
#define LOG2 log2f
#define SQRT sqrtf
#define COPYSIGN copysignf
#endif

#define R(x) ((lt_real)(x))

INLINE uint32_t bits_of(float x)
{
    uint32_t u;

    memcpy(&u, &x, sizeof(u));
    return u;
}

INLINE float of_bits(uint32_t u)
{
    float x;

    memcpy(&x, &u, sizeof(x));
    return x;
}

#ifndef LT_DOUBLE
/* 2^(j / 8) for j < 8, twice, less j in the place where n / 8 has it, 2^20: adding n there leaves the whole power. */
static const uint32_t eighths[16] = {
    0x3f800000, 0x3f7b95c2, 0x3f7837f0, 0x3f75fed7, 0x3f7504f3, 0x3f75672a, 0x3f7744fd, 0x3f7ac0c7,
    0x3f800000, 0x3f7b95c2, 0x3f7837f0, 0x3f75fed7, 0x3f7504f3, 0x3f75672a, 0x3f7744fd, 0x3f7ac0c7,
};
#endif

#endif
