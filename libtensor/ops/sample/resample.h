/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Maps resampled along rows and columns: each output of an axis is a weighed sum of neighbouring inputs.
 */
#ifndef LT_OPS_SAMPLE_RESAMPLE_H
#define LT_OPS_SAMPLE_RESAMPLE_H

#include "libtensor/ops/common.h"

/* Output i = the sum over k < count[i] of weight[i * width + k] * input[first[i] + k] */
typedef struct {
    int64_t n, width;               /* outputs; the longest run that has room */
    int32_t *first, *count;
    lt_real *weight;
} resample_axis;

/* resample_axis_bytes - memory of an axis, a multiple of lt_real's size */
size_t resample_axis_bytes(int64_t n, int64_t width);

/* resample_axis_at - an axis in memory of that size, all of its runs empty */
resample_axis resample_axis_at(void *memory, int64_t n, int64_t width);

/* resample_weigh - add to the weight that output i gives to input p; its first input must be named first.
 * What the width has no room for is left out. */
void resample_weigh(resample_axis *a, int64_t i, int64_t p, double weight);

/* resample_turn - the way back, for gradients: what each input gave to the outputs. t is an empty axis of as
 * many outputs as a has inputs, and wide enough. */
void resample_turn(resample_axis *t, const resample_axis *a);

/* resample_scratch - elements that resample_planes needs beside its arrays: for maps of w columns, and the longest run
 * of an output that `cols` has room for */
int64_t resample_scratch(int64_t rows, int64_t w, int64_t cols, int64_t width);

/* resample_planes - n planes of y (rows->n, cols->n) = or += those of x (h, w) resampled; y and x do not overlap */
void resample_planes(const resample_axis *rows, const resample_axis *cols, const lt_real *x, int64_t h, int64_t w,
                     lt_real *y, int64_t n, bool add, lt_real *scratch);

#endif
