/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a convolution's windows see of crops side by side, as the columns of a matrix: (channel, window) by positions;
 * some columns at a time.
 */
#ifndef MODELS_BACKBONES_CROP_COLUMNS_H
#define MODELS_BACKBONES_CROP_COLUMNS_H

#include "models/backbones/alexnet.h"

typedef struct {
    const alexnet_crops *crops;
    int n, l;                       /* the first n of them; which layer */
    int channels;
    int64_t ld;                     /* elements between rows, and the most columns */
    int64_t from, columns;          /* now: positions of the result from there on, so many */
    int crop, last_crop;            /* the rows of maps that have them begin at row `row` of `crop`, ... */
    int64_t row, last_row;          /* ... and end before row `last_row` of `last_crop` */
} crop_columns;

/* crop_columns_count - positions of the first n crops' results */
int64_t crop_columns_count(const crop_columns *c);

/* crop_columns_next - whole rows from where the last ones ended, no more than ld columns; false: no more rows */
bool crop_columns_next(crop_columns *c);

/* crop_columns_gather - out[(channel, ky, kx) * ld + column] from maps x (channels, crops->in[l]); zeros outside them
 * crop_columns_scatter - its transpose: adds to maps;  crop_columns_clear - zeros there first, in all n crops */
void crop_columns_gather(const crop_columns *c, const lt_real *x, lt_real *out);
void crop_columns_scatter(const crop_columns *c, const lt_real *columns, lt_real *dx);
void crop_columns_clear(const crop_columns *c, lt_real *dx);

#endif
