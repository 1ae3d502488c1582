/* SPDX-License-Identifier: Apache-2.0 */
/*
 * conv/winograd.h and conv/winograd2.h for maps in blocks of channels: F(4x4, 3x3), and F(2x2, 3x3) for small maps.
 * Their transforms read and write lines as they are, and the products in between are those of conv.h. For conv.c only.
 */
#ifndef LT_KERNELS_BLOCKS_WINOGRAD_H
#define LT_KERNELS_BLOCKS_WINOGRAD_H

#include "libtensor/kernels/conv/conv.h"

/* The side of a tile of y: 4, or 2; 0: this convolution is better not computed by tiles. */
int lt_winograd_blocks_side(const lt_conv2d_params *p);

int64_t lt_winograd_blocks_packed(const lt_conv2d_params *p);
void lt_winograd_blocks_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed);
size_t lt_winograd_blocks_work(const lt_conv2d_params *p);
void lt_winograd_blocks_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                                const lt_conv2d_around *around, lt_real *y, void *work);

#endif
