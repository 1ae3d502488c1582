/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The convolution that begins a network, for conv.c only: it reads the few plain maps of an image with a stride
 * of 2, and makes maps in blocks of channels.
 */
#ifndef LT_KERNELS_BLOCKS_STEM_H
#define LT_KERNELS_BLOCKS_STEM_H

#include "libtensor/kernels/conv/conv.h"

bool lt_stem_suits(const lt_conv2d_params *p);

int64_t lt_stem_packed(const lt_conv2d_params *p);
void lt_stem_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed);

/* y and a residual are in blocks, x is not. Each y is one chain over (channel, ky, kx), zeros of the padding
 * included. */
void lt_stem_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed, const lt_conv2d_around *around,
                     lt_real *y);

#endif
