/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Depthwise convolutions of maps in blocks of channels; for conv.c and expand.c. They read some rows at a
 * time, which have the padding's zeros at their sides.
 */
#ifndef LT_KERNELS_BLOCKS_DEPTHWISE_H
#define LT_KERNELS_BLOCKS_DEPTHWISE_H

#include "libtensor/kernels/blocks/conv.h"

/* Whether a depthwise convolution whose window, stride and padding are square is for it */
bool lt_depthwise_blocks_suits(const lt_conv2d_params *p);

/* As lt_conv_blocks_packed and the others */
int64_t lt_depthwise_blocks_packed(const lt_conv2d_params *p);
void lt_depthwise_blocks_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed);
size_t lt_depthwise_blocks_work(const lt_conv2d_params *p);
void lt_depthwise_blocks_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                                 const lt_conv2d_around *around, lt_real *y, void *work);

/* What the tasks of one share: maps of y are cut into bands of rows, and where means are wanted each band has sums. */
typedef struct {
    const lt_conv2d_params *p;
    lt_blocks_window window;
    const lt_real *packed;
    const lt_conv2d_around *around;
    lt_real *y;
    double *sums;                       /* [image][band][channel] */
    int64_t out_h, blocks, bands, band; /* rows of a band */
    int64_t room, rows;                 /* rows of x that are there at a time; of y that they are enough for */
} depthwise_blocks;

/* One band of one block */
typedef struct { int64_t image, band, block; } depthwise_place;

/**
 * depthwise_blocks_cut       - a convolution without its data, in about so many bands
 * depthwise_blocks_sums      - bytes of its sums
 * depthwise_blocks_first_row - the first row of x that row `row` of y reads; depthwise_blocks_end_row: behind its last
 * depthwise_blocks_rows      - rows [from, to) of y in one place, whose first ones come first; x begins with row
 *                              `first` of its map
 * depthwise_blocks_mean      - when all rows are there: the means, if they are wanted
 */
depthwise_blocks depthwise_blocks_cut(const lt_conv2d_params *p, int64_t bands);
size_t depthwise_blocks_sums(const depthwise_blocks *j);
void depthwise_blocks_rows(const depthwise_blocks *j, const depthwise_place *at, const lt_real *x, int64_t first,
                           int64_t from, int64_t to);
void depthwise_blocks_mean(const depthwise_blocks *j);

static inline int64_t depthwise_blocks_first_row(const depthwise_blocks *j, int64_t row)
{
    return lt_max_i64(0, row * j->window.step - j->window.pad);
}

static inline int64_t depthwise_blocks_end_row(const depthwise_blocks *j, int64_t row)
{
    return lt_min_i64(j->window.h, row * j->window.step - j->window.pad + j->window.size);
}

#endif
