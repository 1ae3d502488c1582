/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gradient of a convolution's weights, cut into tasks, and the ways to do them: dw[o][(c, tap)] = the sum over
 * images and positions of dy[o] and of what (c, tap) reads of x. For conv_weights*.c only.
 */
#ifndef LT_KERNELS_CONV_WEIGHTS_H
#define LT_KERNELS_CONV_WEIGHTS_H

#include "libtensor/kernels/conv/internal.h"

enum {
    LT_WEIGHTS_CHANNELS = 64,           /* of x in a task that goes by windows, */
    LT_WEIGHTS_LANES = 128,             /* and of dy, */
    LT_WEIGHTS_SLACK = 16,              /* and what image_rows may write after each channel */
};

typedef enum {
    BY_WINDOW,                          /* 3 x 3 to 7 x 7: a copy of x with its zeros serves all taps */
    BY_SAMPLES,                         /* 1 x 1 with a stride: BY_PRODUCT, after a copy of what it reads */
    BY_PRODUCT,                         /* both factors packed */
} weights_way;

/* What the window goes over at once: a band of output rows, of several images when they are small. */
typedef struct { int64_t rows, images, line, lines, channel; } window_band;

typedef struct {
    lt_conv2d_params p;
    const lt_real *x, *dy;
    bool add;                           /* to what dw holds; else it holds garbage */
    lt_real *dw, *part;                 /* part: what a chunk's tasks sum, where there are several */
    conv_taps taps;
    int64_t positions;                  /* of an output map */
    weights_way way;
    bool tiles, swapped;                /* on AMX's tiles; x on the left and dy on the right */
    window_band band;
    int64_t m, n, tile_m, tile_n, tiles_m, tiles_n, pieces, chunks;
} weights_job;

/* A task: one tile of one group's sums, over some of the images. */
typedef struct {
    const weights_job *j;
    lt_tile t;
    int64_t task, group, chunk, from, to;
} weights_piece;

static inline weights_piece weights_piece_of(const weights_job *j, int64_t task)
{
    const int64_t chunk = task % j->chunks, tile = task / j->chunks;
    const int64_t m0 = tile % j->tiles_m * j->tile_m, n0 = tile / j->tiles_m % j->tiles_n * j->tile_n;

    return (weights_piece){
        j, { m0, lt_min_i64(j->tile_m, j->m - m0), n0, lt_min_i64(j->tile_n, j->n - n0) },
        task, tile / j->tiles_m / j->tiles_n, chunk, chunk * j->p.n / j->chunks, (chunk + 1) * j->p.n / j->chunks,
    };
}

static inline const lt_real *weights_x(const weights_piece *w, int64_t image)
{
    const lt_conv2d_params *p = &w->j->p;

    return w->j->x + (image * p->c + w->group * conv_group_c(p)) * p->h * p->w;
}

static inline const lt_real *weights_dy(const weights_piece *w, int64_t image)
{
    const lt_conv2d_params *p = &w->j->p;

    return w->j->dy + (image * p->o + w->group * conv_group_o(p)) * w->j->positions;
}

/**
 * conv_weights_band       - the largest band that fits the scratch; no rows where none does, or windows do not suit
 * conv_weights_by_windows - work holds pieces * chunks tiles
 */
window_band conv_weights_band(const lt_conv2d_params *p);
void conv_weights_by_windows(weights_job *j);

/**
 * conv_weights_by_product - work holds what is as large as dw for each chunk, unless there is one and it is not swapped
 * conv_weights_add_chunks - the parts of all chunks, each as large as dw, added to it in their order
 */
void conv_weights_by_product(weights_job *j);
void conv_weights_add_chunks(weights_job *j);

#endif
