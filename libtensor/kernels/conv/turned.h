/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pointwise convolution turned round: output channels in the lanes, positions in the rows. For maps whose
 * positions would leave lanes empty: 49 of 64 are used for 7 x 7. The same chains of multiply-adds, so without a gate
 * the same bits, as the direct product. For files of kernels/ only.
 */
#ifndef LT_KERNELS_CONV_TURNED_H
#define LT_KERNELS_CONV_TURNED_H

#include "libtensor/kernels/conv/conv.h"

/* lt_turned_saves - whether enough fewer lanes stay empty with m channels in them than with n positions
 * lt_turned_suits - whether that pays for this convolution */
bool lt_turned_saves(int64_t n, int64_t m);
bool lt_turned_suits(const lt_conv2d_params *p);

/* The parts, for other convolutions whose channels are in the lanes. */
enum {
    LT_TURNED_LANES = 64,       /* the most of any instruction set's panel */
    LT_TURNED_MOST = 8192,      /* elements of a tile of lt_turned_place */
};

/* lt_turned_rows - positions of a tile, of n in each of `parts` */
int64_t lt_turned_rows(int64_t n, int64_t parts);

/* lt_turned_product - c[row * ldc + lane] = sum over l < k of x[l * ldx + row] times a panel b, [k][nr], of n lanes */
void lt_turned_product(lt_real *c, int64_t ldc, const lt_real *x, int64_t ldx, const lt_real *b, int64_t rows,
                       int64_t n, int64_t k, const lt_epilogue *e);

/* lt_turned_place - y[lane * ld + row] = tile[row * ld_tile + lane]; a residual, laid out as y, comes with the
 * activation behind it, and without one the tile is complete */
void lt_turned_place(lt_real *y, int64_t ld, const lt_real *residual, lt_act act, const lt_real *tile, int64_t ld_tile,
                     int64_t rows, int64_t n);

#endif
