/* SPDX-License-Identifier: Apache-2.0 */
/*
 * 2-d convolution and its two gradients on plain NCHW maps, as products that are packed straight from
 * the image. Cut by the shape alone: the same bits on any number of threads and any instruction set.
 */
#ifndef LT_KERNELS_CONV_H
#define LT_KERNELS_CONV_H

#include "libtensor/kernels/kernels.h"

#ifdef __cplusplus
extern "C" {
#endif

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

/**
 * lt_conv2d_forward - y = act(conv(x, weights) + bias + residual)
 *
 * bias (o) and residual (the shape of y) may be NULL. Each y is one chain of fused multiply-adds over
 * (channel, ky, kx), zeros of the padding included, then bias, then residual, then act.
 */
LT_API void lt_conv2d_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *weights,
                              const lt_real *bias, const lt_real *residual, lt_act act, lt_real *y);

/**
 * lt_conv2d_backward_data - dx += the gradient of x
 *
 * Also the forward pass of a transposed convolution, with dy in the place of its input, into dx
 * cleared beforehand.
 */
LT_API void lt_conv2d_backward_data(const lt_conv2d_params *p, const lt_real *dy,
                                    const lt_real *weights, lt_real *dx);

/**
 * lt_conv2d_backward_weights - dw += the gradient of the weights
 *
 * work is lt_conv2d_weights_work(p) bytes, aligned to LT_ALIGN, contents indifferent: the batch is
 * cut into a fixed number of chunks, each summed on its own, then added in order.
 */
LT_API size_t lt_conv2d_weights_work(const lt_conv2d_params *p);
LT_API void lt_conv2d_backward_weights(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy,
                                       lt_real *dw, void *work);

/* lt_conv2d_backward_bias - dbias[o] += sum of dy over images and positions */
LT_API void lt_conv2d_backward_bias(const lt_conv2d_params *p, const lt_real *dy, lt_real *dbias);

#ifdef __cplusplus
}
#endif
#endif
