/* SPDX-License-Identifier: Apache-2.0 */
/*
 * F(2x2, 3x3) [Lavin and Gray 2016] for small maps: a 3 x 3 convolution of stride 1 and pad 1 computed two by two
 * outputs at a time, with 16 multiplications in the place of 36. The windows grow by 16 / 9 only, which counts
 * where they are read once for some 16 tiles; and channels are in the lanes, as there are hardly any tiles.
 *
 * A 4 x 4 tile d of the input becomes B^T d B, the window G g G^T; A^T (.) A brings the sums over channels back.
 * Points 0, 1, -1 and infinity. For conv*.c only.
 */
#ifndef LT_KERNELS_CONV_WINOGRAD2_H
#define LT_KERNELS_CONV_WINOGRAD2_H

#include "libtensor/kernels/conv/conv.h"

/* Whether the shape gains. The same for the gradient of x. */
bool lt_winograd2_suits(const lt_conv2d_params *p);

#endif
