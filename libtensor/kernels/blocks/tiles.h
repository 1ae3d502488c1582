/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Convolutions between maps in blocks of channels as products on AMX's tiles (kernels.h: lt_tiles), faster than
 * multiply-adds where many positions meet the weights. For libtensor/kernels/blocks/conv.c, whose functions say what
 * these do. Each y is within 1e-6 of the sum of its terms' sizes from the exact one, and NaN where a factor is
 * infinite.
 */
#ifndef LT_KERNELS_BLOCKS_TILES_H
#define LT_KERNELS_BLOCKS_TILES_H

#include "libtensor/kernels/conv/conv.h"

/* lt_conv_tiles_suits - whether this CPU has tiles, and the convolution, of one group, enough to do */
bool lt_conv_tiles_suits(const lt_conv2d_params *p);

int64_t lt_conv_tiles_packed(const lt_conv2d_params *p);
void lt_conv_tiles_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed);
void lt_conv_tiles_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                           const lt_conv2d_around *around, lt_real *y);

#endif
