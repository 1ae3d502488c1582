/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What every file of libtensor shares: the scalar type, visibility, and size arithmetic that knows
 * when it overflowed.
 */
#ifndef LT_BASE_COMMON_H
#define LT_BASE_COMMON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Marks a function that leaves the shared library; everything else stays inside. */
#if defined(__GNUC__)
#define LT_API __attribute__((visibility("default")))
#define LT_PRINTF(fmt, first) __attribute__((format(printf, fmt, first)))
#else
#define LT_API
#define LT_PRINTF(fmt, first)
#endif

/* The scalar of tensors and kernels. The library is compiled a second time with LT_DOUBLE, for tests
 * only, so that gradients can be checked against central differences to 1e-6. */
#ifdef LT_DOUBLE
typedef double lt_real;
#define LT_REAL_FMT "f8"
#else
typedef float lt_real;
#define LT_REAL_FMT "f4"
#endif

enum { LT_ALIGN = 64 };         /* bytes: a cache line, and the widest vector */

#define LT_COUNT(array) (sizeof(array) / sizeof((array)[0]))

static inline int64_t lt_min_i64(int64_t a, int64_t b) { return a < b ? a : b; }
static inline int64_t lt_max_i64(int64_t a, int64_t b) { return a > b ? a : b; }
static inline int64_t lt_ceil_div(int64_t a, int64_t b) { return (a + b - 1) / b; }

/* lt_size_mul, lt_size_add - true and *out = a * b (a + b), or false when that does not fit size_t */
static inline bool lt_size_mul(size_t a, size_t b, size_t *out)
{
    return !__builtin_mul_overflow(a, b, out);
}

static inline bool lt_size_add(size_t a, size_t b, size_t *out)
{
    return !__builtin_add_overflow(a, b, out);
}

#ifdef __cplusplus
}
#endif
#endif
