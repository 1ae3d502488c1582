/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pointwise convolution turned round: output channels in the lanes, positions in the rows. For maps whose
 * positions would leave lanes empty: 49 of 64 are used for 7 x 7. The same chains of multiply-adds, so the same
 * bits, as the direct product. For files of kernels/ only.
 */
#ifndef LT_KERNELS_CONV_TURNED_H
#define LT_KERNELS_CONV_TURNED_H

#include "libtensor/kernels/conv.h"

/* lt_turned_suits - whether fewer lanes stay empty this way */
bool lt_turned_suits(const lt_conv2d_params *p);

/* As lt_conv2d_packed, lt_conv2d_pack, lt_conv2d_forward_work (bytes) and lt_conv2d_forward. */
int64_t lt_turned_packed(const lt_conv2d_params *p);
void lt_turned_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed);
size_t lt_turned_work(const lt_conv2d_params *p);
void lt_turned_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                       const lt_conv2d_around *around, lt_real *y, lt_real *work);

#endif
