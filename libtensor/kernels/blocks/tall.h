/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Convolutions of one column, as those of a graph network in time: F(4, 5) [Lavin and Gray 2016; Winograd 1980] down
 * the map, four outputs with 8 multiplications for each five taps. Taps that are a stride apart see a map of stride 1
 * of their own; they go by five, and all parts of a window are summed before they are brought back.
 *
 * Eight rows d of the input become B^T d, five taps G g; A^T (.) brings the sums back. Points 0, 1, -1, 2, -2, 1/2,
 * -1/2 and infinity. For conv.c only.
 */
#ifndef LT_KERNELS_BLOCKS_TALL_H
#define LT_KERNELS_BLOCKS_TALL_H

#include "libtensor/kernels/conv/conv.h"

/* Whether the shape gains, what windows see of the padding left aside */
bool lt_tall_suits(const lt_conv2d_params *p);

int64_t lt_tall_packed(const lt_conv2d_params *p);
void lt_tall_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed);
size_t lt_tall_work(const lt_conv2d_params *p);
void lt_tall_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed, const lt_conv2d_around *around,
                     lt_real *y, void *work);

#endif
