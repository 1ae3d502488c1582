/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A convolution between small maps tap by tap: one product gives what every tap makes of every position, channels in
 * the lanes, and each place of the result sums its taps:
 *   q[position][tap, m] = sum over k of x[k][position] w[k][tap, m]
 *   y[m][place] = sum over taps of q[position of tap][tap, m]
 * No window is copied, and no lane stays empty. The gradient of x, strided as well, is the same with other places.
 * Each q is one chain of multiply-adds over k, in blocks as in every product, or comes from AMX's tiles, with the
 * positions of all images as rows (gemm/tiles.h); taps are added by rows of the window.
 * For files of kernels/ only.
 */
#ifndef LT_KERNELS_CONV_TAPWISE_H
#define LT_KERNELS_CONV_TAPWISE_H

#include "libtensor/kernels/conv/way.h"

/* lt_tapwise_suits - whether the shape is one of those that gain */
bool lt_tapwise_suits(const lt_conv2d_params *p, conv_direction d);

#endif
