/* SPDX-License-Identifier: Apache-2.0 */
/* Weights as 8-bit integers in words; for this folder only. */
#ifndef LT_KERNELS_INT8_WEIGHTS_H
#define LT_KERNELS_INT8_WEIGHTS_H

#include "libtensor/kernels/kernels.h"

enum {
    INT8_WORD = 4,                  /* bytes */
    INT8_MOST_K = 65536,            /* products of a sum: 255 * 127 each, together below 2^31 */
    INT8_LEAST_K = 16,              /* products of a sum below which rounding does not pay */
};

static inline int64_t int8_words(int64_t k) { return lt_ceil_div(k, INT8_WORD); }

/**
 * int8_weights - `rows` rows of weights (channels, taps) as words (channels / 4 rounded up, taps)
 *
 * scale[row] is the largest weight's size over 127, times r's scale; start[row] holds -128 times the sum of the row's
 * integers where r has a sign, 0 otherwise. In parallel.
 */
void int8_weights(const lt_real *w, int64_t rows, int64_t channels, int64_t taps, const lt_int8_range *r,
                  lt_real *words, lt_real *scale, lt_real *start);

#endif
