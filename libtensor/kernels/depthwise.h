/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Convolution where each group has one input channel, or where there are hardly any outputs: no product to speak
 * of, so each map goes through L1 on its own. For conv.c only; contracts as in conv.h.
 */
#ifndef LT_KERNELS_DEPTHWISE_H
#define LT_KERNELS_DEPTHWISE_H

#include "libtensor/kernels/conv.h"

/* lt_depthwise_forward - mean, unless NULL, gets the mean of each map of y: (n, o) */
void lt_depthwise_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *weights,
                          const lt_epilogue *e, lt_real *y, lt_real *mean);

/* lt_few_suits - whether lt_depthwise_forward serves: few outputs, each summing over the windows of all maps */
bool lt_few_suits(const lt_conv2d_params *p);

void lt_depthwise_backward_data(const lt_conv2d_params *p, const lt_real *dy, const lt_real *weights,
                                bool add, lt_real *dx);

/* lt_depthwise_backward_weights - part[chunk] = the whole gradient of that chunk of images */
void lt_depthwise_backward_weights(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy,
                                   int64_t chunks, lt_real *part);

#endif
