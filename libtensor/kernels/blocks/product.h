/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Convolutions between maps in blocks of channels as products by multiply-adds: what neither Winograd's transforms, nor
 * AMX's tiles, nor depthwise windows do better. For libtensor/kernels/blocks/conv.c, whose functions say what these do.
 */
#ifndef LT_KERNELS_BLOCKS_PRODUCT_H
#define LT_KERNELS_BLOCKS_PRODUCT_H

#include "libtensor/kernels/conv/conv.h"

int64_t lt_blocks_product_packed(const lt_conv2d_params *p);
void lt_blocks_product_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed);
size_t lt_blocks_product_work(const lt_conv2d_params *p);
void lt_blocks_product_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                               const lt_conv2d_around *around, lt_real *y, lt_real *work);

#endif
