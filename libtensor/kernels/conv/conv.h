/* SPDX-License-Identifier: Apache-2.0 */
/*
 * 2-d convolution and its two gradients on plain NCHW maps, as products that are packed straight from
 * the image. Cut by the shape alone: the same bits on any number of threads, and on any instruction set but LT_ISA_AMX,
 * whose tiles are within 1e-6 of the sum of the terms' sizes from the others.
 */
#ifndef LT_KERNELS_CONV_CONV_H
#define LT_KERNELS_CONV_CONV_H

#include "libtensor/kernels/kernels.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LT_CONV_MOST_TAPS = 1024 };      /* kh * kw */

/* x is (n, c, h, w), weights are (o, c / groups, kh, kw), y is (n, o, out_h, out_w). */
typedef struct {
    int64_t n, c, h, w;
    int64_t o;
    int kh, kw;
    int stride_h, stride_w;         /* >= 1 */
    int pad_h, pad_w;               /* zeros on both sides, >= 0 */
    int dil_h, dil_w;               /* >= 1 */
    int groups;                     /* divides c and o */
} lt_conv2d_params;

/* lt_conv2d_out_h, lt_conv2d_out_w - size of y; below 1 when the window does not fit */
LT_API int64_t lt_conv2d_out_h(const lt_conv2d_params *p);
LT_API int64_t lt_conv2d_out_w(const lt_conv2d_params *p);

/* Rows [y0, y1) and columns [x0, x1) of a map */
typedef struct { int64_t y0, y1, x0, x1; } lt_rect;

/* lt_conv2d_all - every position of y */
LT_API lt_rect lt_conv2d_all(const lt_conv2d_params *p);

/* How a convolution is computed: a function of its shape, and of whether there are AMX's tiles. */
typedef enum {
    LT_CONV_DIRECT,         /* a product, packed straight from the map */
    LT_CONV_TILES,          /* that product on AMX's tiles: libtensor/kernels/gemm/product_tiles.c */
    LT_CONV_TURNED,         /* that product with channels in the lanes: libtensor/kernels/conv/turned.h */
    LT_CONV_TAPWISE,        /* a product for each tap, and their sums: libtensor/kernels/conv/tapwise.h */
    LT_CONV_WINOGRAD,       /* F(4x4, 3x3): libtensor/kernels/conv/winograd.h */
    LT_CONV_WINOGRAD2,      /* F(2x2, 3x3), small maps: libtensor/kernels/conv/winograd2.h */
    LT_CONV_DEPTHWISE,      /* one input channel for each group, and few outputs */
    LT_CONV_FEW,            /* hardly any outputs: maps go one by one, as in a depthwise convolution */
} lt_conv_algorithm;

LT_API lt_conv_algorithm lt_conv2d_algorithm(const lt_conv2d_params *p);

/**
 * lt_conv2d_pack - the weights in the order in which forward reads them
 *
 * packed has lt_conv2d_packed(p) elements. It serves the instruction set in use: ask and pack again after
 * lt_kernels_use.
 */
LT_API int64_t lt_conv2d_packed(const lt_conv2d_params *p);
LT_API void lt_conv2d_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed);

/* What goes on around a convolution, each part optional (NULL): y = act(conv(x gate) + bias + residual) */
typedef struct {
    const lt_real *gate;        /* (n, c): what each map of x is multiplied with, or its weights where they are fewer;
                                 * pointwise, one group */
    const lt_real *bias;        /* (o) */
    const lt_real *residual;    /* the shape of y; may be y itself */
    lt_act act;
    lt_real *mean;              /* (n, o): gets the mean of each map of y; depthwise */
} lt_conv2d_around;

/* lt_conv2d_takes_gate, lt_conv2d_makes_mean - can that be asked for? */
LT_API bool lt_conv2d_takes_gate(const lt_conv2d_params *p);
LT_API bool lt_conv2d_makes_mean(const lt_conv2d_params *p);

/**
 * lt_conv2d_forward - y = act(conv(x gate) + bias + residual)
 *
 * work is lt_conv2d_forward_work(p) bytes, aligned to LT_ALIGN, contents indifferent. Direct, turned: each y is one
 * chain of fused multiply-adds over (channel, ky, kx), zeros of the padding included, then bias, then
 * residual, then act. Depthwise, few: over (channel, kx, ky). Winograd: within 4e-6 of the sum of the terms' sizes
 * from that.
 */
LT_API size_t lt_conv2d_forward_work(const lt_conv2d_params *p);
LT_API void lt_conv2d_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                              const lt_conv2d_around *around, lt_real *y, void *work);

/**
 * lt_conv2d_forward_rect - the same for one image, and only for the positions of y that r has
 *
 * The rest of y stays as it was. packed is that of lt_conv2d_pack for the same p; x, residual and y begin
 * with the image. r may be empty. Depthwise and grouped convolutions, or those of other strides than 1, are
 * not for this: lt_conv2d_takes_rect says no. Direct: the same bits as lt_conv2d_forward.
 */
LT_API bool lt_conv2d_takes_rect(const lt_conv2d_params *p);
LT_API size_t lt_conv2d_rect_work(const lt_conv2d_params *p);
LT_API void lt_conv2d_forward_rect(const lt_conv2d_params *p, lt_rect r, const lt_real *x, const lt_real *packed,
                                   const lt_real *bias, const lt_real *residual, lt_act act, lt_real *y,
                                   void *work);

/* lt_conv2d_data_pack - as lt_conv2d_pack, for lt_conv2d_backward_data: lt_conv2d_data_packed(p) elements */
LT_API int64_t lt_conv2d_data_packed(const lt_conv2d_params *p);
LT_API void lt_conv2d_data_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed);

/**
 * lt_conv2d_backward_data - dx = the gradient of x, or dx += it
 *
 * work is lt_conv2d_backward_data_work(p) bytes, as above. Also the forward pass of a transposed
 * convolution, with its input in the place of dy.
 */
LT_API size_t lt_conv2d_backward_data_work(const lt_conv2d_params *p);
LT_API void lt_conv2d_backward_data(const lt_conv2d_params *p, const lt_real *dy, const lt_real *packed,
                                    bool add, lt_real *dx, void *work);

/**
 * lt_conv2d_backward_weights - dw = the gradient of the weights, or dw += it
 *
 * work is lt_conv2d_weights_work(p) bytes, aligned to LT_ALIGN, contents indifferent: the batch is
 * cut into a fixed number of chunks, each summed on its own, then added in order. 3 x 3 windows of stride 1 and pad 1
 * from 32 channels, 8 x 8 positions and 16 tiles of 4 x 4 on go by libtensor/kernels/conv/winograd_weights.h: within
 * 4e-6 of the sum of the terms' sizes.
 */
LT_API size_t lt_conv2d_weights_work(const lt_conv2d_params *p);
LT_API void lt_conv2d_backward_weights(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy,
                                       bool add, lt_real *dw, void *work);

/* lt_conv2d_backward_bias - dbias[o] += sum of dy over images and positions */
LT_API void lt_conv2d_backward_bias(const lt_conv2d_params *p, const lt_real *dy, lt_real *dbias);

/* Where gradients are added to; NULL: not wanted */
typedef struct { lt_real *x, *weights, *bias; } lt_conv2d_gradients;

/**
 * lt_conv2d_backward_rects - all gradients, dy of image i taken as 0 outside r[i]
 *
 * A rectangle may be empty. work is lt_conv2d_backward_rects_work(p) bytes, aligned to LT_ALIGN, contents indifferent.
 * Only for windows larger than 1 x 1 whose result is as large as the map, at stride 1: lt_conv2d_stacks_rects.
 */
LT_API bool lt_conv2d_stacks_rects(const lt_conv2d_params *p);
LT_API size_t lt_conv2d_backward_rects_work(const lt_conv2d_params *p);
LT_API void lt_conv2d_backward_rects(const lt_conv2d_params *p, const lt_rect *r, const lt_real *x,
                                     const lt_real *weights, const lt_real *dy, const lt_conv2d_gradients *to,
                                     void *work);

#ifdef __cplusplus
}
#endif
#endif
