/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Convolutions between maps in blocks of channels (kernels.h: LT_BLOCK). A product reads such maps where they are, and
 * writes its results in whole lines: in chains of convolutions neither is packed, nor turned, nor scattered over planes
 * whose rows share sets of the caches. Which bits come out depends on the shapes, and on whether the CPU has AMX.
 */
#ifndef LT_KERNELS_BLOCKS_CONV_H
#define LT_KERNELS_BLOCKS_CONV_H

#include "libtensor/kernels/blocks/blocks.h"
#include "libtensor/kernels/conv/conv.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lt_conv_blocks_takes - whether there is such a form of a convolution; lt_conv_blocks_reads_plain: whether x stays
 * plain there, as the few maps of an image do; lt_conv_blocks_name: of its algorithm */
LT_API bool lt_conv_blocks_takes(const lt_conv2d_params *p);
LT_API bool lt_conv_blocks_reads_plain(const lt_conv2d_params *p);
LT_API const char *lt_conv_blocks_name(const lt_conv2d_params *p);

/* As lt_conv2d_packed, lt_conv2d_pack, lt_conv2d_forward_work and lt_conv2d_forward; x, y and a residual,
 * which is not y itself, are in blocks.
 * Products: each y is one chain over (ky, kx, channel), zeros of the padding included, from plain maps over (channel,
 * ky, kx); depthwise: over (ky, kx), with zeros at the sides;
 * Winograd: within 4e-6 of the sum of the terms' sizes from that, and products on AMX's tiles, where
 * lt_conv_blocks_name says so, within 1e-6 of the exact sum. A mean is summed in double, position by position. */
LT_API int64_t lt_conv_blocks_packed(const lt_conv2d_params *p);
LT_API void lt_conv_blocks_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed);
LT_API size_t lt_conv_blocks_work(const lt_conv2d_params *p);
LT_API void lt_conv_blocks_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                                   const lt_conv2d_around *around, lt_real *y, void *work);

/* A convolution with its packed weights and what surrounds it */
typedef struct {
    const lt_conv2d_params *p;
    const lt_real *packed;
    lt_conv2d_around around;
} lt_conv_blocks_step;

/**
 * lt_conv_blocks_pair_forward - a pointwise convolution and the depthwise one behind it, whose input nobody else reads
 *
 * The same bits as lt_conv_blocks_forward twice, but for means, which are summed in other parts; the same packed
 * weights. Of what surrounds the first there may be a bias and an activation. lt_conv_blocks_pair_suits: whether it is
 * better so.
 */
LT_API bool lt_conv_blocks_pair_suits(const lt_conv2d_params *first, const lt_conv2d_params *second);
LT_API size_t lt_conv_blocks_pair_work(const lt_conv2d_params *first, const lt_conv2d_params *second);
LT_API void lt_conv_blocks_pair_forward(const lt_conv_blocks_step *first, const lt_conv_blocks_step *second,
                                        const lt_real *x, lt_real *y, void *work);

#ifdef __cplusplus
}
#endif
#endif
