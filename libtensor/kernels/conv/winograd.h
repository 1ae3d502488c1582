/* SPDX-License-Identifier: Apache-2.0 */
/*
 * F(4x4, 3x3) [Lavin and Gray 2016]: a 3 x 3 convolution of stride 1 and pad 1 computed four by four
 * outputs at a time, with 36 multiplications in the place of 144. For conv*.c only.
 *
 * A 6 x 6 tile d of the input becomes B^T d B, the window G g G^T; for each of the 36 places the products
 * over channels are one matrix product (rows: output channels, columns: tiles); A^T (.) A brings the
 * result back. Points 0, 1, -1, 2, -2 and infinity.
 */
#ifndef LT_KERNELS_CONV_WINOGRAD_H
#define LT_KERNELS_CONV_WINOGRAD_H

#include "libtensor/kernels/conv/way.h"

/* Whether any of Winograd's ways is for it: 3 x 3, stride 1, pad 1, at least 32 channels on both sides */
bool lt_winograd_form(const lt_conv2d_params *p);

/* Where size x size positions from (y, x) on are in an h x w map of [position][LT_BLOCK]; zeros around it */
void lt_winograd_look(const lt_real **d, const lt_real *map, int64_t h, int64_t w, int64_t y, int64_t x, int size);

/* Whether the shape gains: neither few channels nor few tiles. The same for the gradient of x. */
bool lt_winograd_suits(const lt_conv2d_params *p);

/* The window between each map that goes out and each that comes in, for wino_windows and wino2_windows. The gradient's
 * are the same ones turned round, with the maps' parts exchanged. */
static inline lt_windows lt_winograd_windows(const lt_conv2d_params *p, conv_direction d, const lt_real *weights)
{
    const bool forward = d == CONV_FORWARD;

    return (lt_windows){ weights, forward ? p->c * 9 : 9, forward ? 9 : p->c * 9, !forward };
}

/* Forward, of one image, of which only the positions of r are written; r has at least one. */
size_t lt_winograd_rect_work(const lt_conv2d_params *p);
void lt_winograd_run_rect(const lt_conv2d_params *p, lt_rect r, const lt_real *x, const lt_real *packed,
                          const lt_epilogue *e, lt_real *y, void *work);

#endif
