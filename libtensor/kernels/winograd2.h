/* SPDX-License-Identifier: Apache-2.0 */
/*
 * F(2x2, 3x3) [Lavin and Gray 2016] for small maps: a 3 x 3 convolution of stride 1 and pad 1 computed two by two
 * outputs at a time, with 16 multiplications in the place of 36. The windows grow by 16 / 9 only, which counts
 * where they are read once for some 16 tiles; and channels are in the lanes, as there are hardly any tiles.
 *
 * A 4 x 4 tile d of the input becomes B^T d B, the window G g G^T; A^T (.) A brings the sums over channels back.
 * Points 0, 1, -1 and infinity. For conv*.c only.
 */
#ifndef LT_KERNELS_WINOGRAD2_H
#define LT_KERNELS_WINOGRAD2_H

#include "libtensor/kernels/conv.h"

/* Whether the shape gains. The same for the gradient of x. */
bool lt_winograd2_suits(const lt_conv2d_params *p);

/* As in winograd.h: from k channels to m; elements of the packed windows; bytes of work. */
int64_t lt_winograd2_packed(int64_t m, int64_t k);
size_t lt_winograd2_work(const lt_conv2d_params *p, int64_t m, int64_t k);
void lt_winograd2_pack(const lt_real *w, int64_t row, int64_t col, bool flip, int64_t m, int64_t k, lt_real *packed);

/* x is (n, k, h, w), y is (n, m, h, w); a residual has y's shape and may be y */
void lt_winograd2_run(const lt_conv2d_params *p, int64_t m, int64_t k, const lt_real *x, const lt_real *packed,
                      const lt_conv2d_around *around, lt_real *y, lt_real *work);

#endif
