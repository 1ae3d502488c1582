/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The cells of all levels, each of which may find an object, in one order: levels, rows, columns.
 */
#ifndef MODELS_DETECT_CELLS_H
#define MODELS_DETECT_CELLS_H

#include "libtensor/graph/op.h"
#include "models/detect/ciou.h"
#include "models/detect/head.h"

/* One of the cells of an image */
typedef struct {
    int level;
    int64_t at, plane;              /* its place in each H x W plane of its level; H W */
    double stride;                  /* pixels of a cell */
    double x, y;                    /* the centre, in cells */
} cell;

/* cells_of - how many there are in maps in[0 .. DETECT_LEVELS - 1] of a call; cell_at - number i */
int64_t cells_of(const lt_call *c);
cell cell_at(const lt_call *c, int64_t i);

/* cells_check - the shape rule of maps in[0 .. DETECT_LEVELS - 1]: (B, channels, H, W), of one B; channels 0: as many
 * as the first has */
lt_status cells_check(lt_call *c, const char *what, int64_t channels);

/* cell_values - of in[level], the cell's first channel in image b; the next is one plane further */
const lt_real *cell_values(const lt_call *c, int64_t b, const cell *at);

/* cell_box - from a cell's 4 x 16 bins to a box, in cells: each side is as far from the centre as the mean bin says.
 * q (64): NULL, or the softmax of each side */
ciou_box cell_box(const cell *at, const lt_real *bins, double *q);

enum { OBJECT_NUMBERS = 6 };
enum { OBJECT_CLASS, OBJECT_X0, OBJECT_Y0, OBJECT_X1, OBJECT_Y1, OBJECT_HAS_MASK };

/* object_at - number i of image b of a tensor (B, G, 6), or NULL where there is none: its class is below 0 */
const lt_real *object_at(const lt_tensor *objects, int64_t b, int64_t i);

/* object_box - in cells of a stride */
ciou_box object_box(const lt_real *object, double stride);

#endif
