/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Convolution where each group has one input channel, or where there are hardly any outputs: no product to speak
 * of, so each map goes through L1 on its own. Contracts as in conv.h.
 */
#ifndef LT_KERNELS_CONV_DEPTHWISE_H
#define LT_KERNELS_CONV_DEPTHWISE_H

#include "libtensor/kernels/conv/conv.h"

/* lt_few_suits - whether conv_depthwise serves forward: few outputs, each summing over the windows of all maps */
bool lt_few_suits(const lt_conv2d_params *p);

/* lt_depthwise_backward_weights - part[chunk] = the whole gradient of that chunk of images */
void lt_depthwise_backward_weights(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy,
                                   int64_t chunks, lt_real *part);

/* ---- a map at a time, for ops that make it when it is read ---- */

typedef struct {
    lt_conv2d_params p;
    lt_depthwise forward, data;     /* how the kernels go over x, and over dy for the gradient of x */
} lt_depthwise_maps;

/* lt_depthwise_by_maps - whether each map can go alone as fast as with others: one output each, a square window of 3
 * or 5, steps of 1 or 2, and a map that is large but fits a thread's scratch, LT_SCRATCH_A and LT_SCRATCH_B */
bool lt_depthwise_by_maps(lt_depthwise_maps *m, const lt_conv2d_params *p);

/* Of one map x (h, w) under its window w: y (out_h, out_w), and dx (h, w) of dy */
void lt_depthwise_map(const lt_depthwise_maps *m, const lt_real *x, const lt_real *w, lt_real *y);
void lt_depthwise_map_data(const lt_depthwise_maps *m, const lt_real *dy, const lt_real *w, lt_real *dx);

/* lt_depthwise_map_weights - add one map's part of the window's gradient to sums, which begin as zeros. next_x and
 * next_dy will be read soon.
 * lt_depthwise_sum_weights - add them all to dw (kh, kw) */
enum { LT_DEPTHWISE_SUMS = 25 * LT_DEPTHWISE_LANES };
void lt_depthwise_map_weights(const lt_depthwise_maps *m, double sums[LT_DEPTHWISE_SUMS], const lt_real *x,
                              const lt_real *dy, const lt_real *next_x, const lt_real *next_dy);
void lt_depthwise_sum_weights(const lt_depthwise_maps *m, const double sums[LT_DEPTHWISE_SUMS], lt_real *dw);

#endif
