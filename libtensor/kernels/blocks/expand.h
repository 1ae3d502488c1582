/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The first half of an inverted bottleneck, in blocks of channels: a pointwise convolution and the depthwise one behind
 * it, some channels at a time. What lies between, the widest maps of such a network, is only there some rows at a time,
 * in the cache of the thread that makes and reads it. For conv.c, which says what these do.
 * Source: Sandler et al. 2018, "MobileNetV2", sections 3.3 and 5.
 */
#ifndef LT_KERNELS_BLOCKS_EXPAND_H
#define LT_KERNELS_BLOCKS_EXPAND_H

#include "libtensor/kernels/blocks/conv.h"

/* Whether the sizes suit a product and a depthwise convolution that are otherwise fit for each other */
bool lt_expand_blocks_suits(const lt_conv2d_params *first, const lt_conv2d_params *second);
size_t lt_expand_blocks_work(const lt_conv2d_params *first, const lt_conv2d_params *second);
void lt_expand_blocks_forward(const lt_conv_blocks_step *first, const lt_conv_blocks_step *second, const lt_real *x,
                              lt_real *y, void *work);

#endif
