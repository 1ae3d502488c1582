/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gradient of a 3 x 3 window's weights by the transpose of F(4x4, 3x3), for weights.c only.
 *
 * y = A^T [(G g G^T) * (B^T d B)] A is linear in g, so that a tile's share of g's gradient is
 * G^T [(A dy A^T) * (B^T d B)] G: 36 multiplications in the place of 144, and for each of the 36 places the sum over
 * tiles is one matrix product (rows: input channels, columns: output channels).
 */
#ifndef LT_KERNELS_CONV_WINOGRAD_WEIGHTS_H
#define LT_KERNELS_CONV_WINOGRAD_WEIGHTS_H

#include "libtensor/kernels/conv/conv.h"

/* Whether the shape gains */
bool lt_winograd_weights_suits(const lt_conv2d_params *p);

/* Bytes of work */
size_t lt_winograd_weights_work(const lt_conv2d_params *p);

/* dw = the gradient, or dw += it */
void lt_winograd_weights_run(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy, bool add, lt_real *dw,
                             void *work);

#endif
