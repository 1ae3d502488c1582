/* SPDX-License-Identifier: Apache-2.0 */
/* The weights of a convolution in the order in which its kernels read them, for plans without gradients. */
#ifndef LT_OPS_CONV_CONV2D_PACK_H
#define LT_OPS_CONV_CONV2D_PACK_H

#include "libtensor/kernels/conv/conv.h"
#include "libtensor/kernels/int8/int8.h"
#include "libtensor/ops/common.h"

typedef struct {
    lt_conv2d_params p;
    lt_int8_range range;        /* as the convolution reads its input; scale 0: as it is */
    bool blocks;                /* for maps in blocks of channels */
} conv2d_packing;

/* op_conv2d_pack - w (O, C / groups, kh, kw), times scale (O) unless that is NULL, packed */
lt_tensor *op_conv2d_pack(lt_tensor *w, lt_tensor *scale, const conv2d_packing *how);

#endif
