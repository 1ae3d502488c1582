/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A convolution between small maps tap by tap: one product gives what every tap makes of every position, channels in
 * the lanes, and each place of the result sums its taps:
 *   q[position][tap, m] = sum over k of x[k][position] w[k][tap, m]
 *   y[m][place] = sum over taps of q[position of tap][tap, m]
 * No window is copied, and no lane stays empty. The gradient of x, strided as well, is the same with other places.
 * Each q is one chain of multiply-adds over k, in blocks as in every product, or comes from AMX's tiles, with the
 * positions of all images as rows (gemm_tiles.h); taps are added by rows of the window.
 * For files of kernels/ only.
 */
#ifndef LT_KERNELS_CONV_TAPWISE_H
#define LT_KERNELS_CONV_TAPWISE_H

#include "libtensor/kernels/conv.h"

typedef enum { LT_TAPWISE_FORWARD, LT_TAPWISE_DATA } lt_tapwise_way;

/* lt_tapwise_suits - whether the shape is one of those that gain */
bool lt_tapwise_suits(const lt_conv2d_params *p, lt_tapwise_way way);

/* As lt_conv2d_packed, lt_conv2d_pack, lt_conv2d_forward_work (bytes), and those of the gradient of x. */
int64_t lt_tapwise_packed(const lt_conv2d_params *p, lt_tapwise_way way);
void lt_tapwise_pack(const lt_conv2d_params *p, lt_tapwise_way way, const lt_real *weights, lt_real *packed);
size_t lt_tapwise_work(const lt_conv2d_params *p, lt_tapwise_way way);

/* lt_tapwise_run - y from x, or (LT_TAPWISE_DATA) y = dx, added to or not, from x = dy, with nothing around */
void lt_tapwise_run(const lt_conv2d_params *p, lt_tapwise_way way, const lt_real *x, const lt_real *packed,
                    const lt_conv2d_around *around, bool add, lt_real *y, lt_real *work);

#endif
