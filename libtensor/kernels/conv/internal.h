/* SPDX-License-Identifier: Apache-2.0 */
/* What the directions of a convolution share: sizes, and how a window lies on a map. For kernels/ only. */
#ifndef LT_KERNELS_CONV_INTERNAL_H
#define LT_KERNELS_CONV_INTERNAL_H

#include "libtensor/kernels/conv/conv.h"
#include "libtensor/kernels/gemm/product.h"

static inline int64_t conv_group_c(const lt_conv2d_params *p) { return p->c / p->groups; }
static inline int64_t conv_group_o(const lt_conv2d_params *p) { return p->o / p->groups; }

static inline int64_t conv_weight_count(const lt_conv2d_params *p)
{
    return p->o * conv_group_c(p) * p->kh * p->kw;
}

static inline bool conv_pointwise(const lt_conv2d_params *p)
{
    return p->kh == 1 && p->kw == 1 && p->stride_h == 1 && p->stride_w == 1 && !p->pad_h && !p->pad_w;
}

/* Neither input nor output, or too large a window: nothing is done. */
static inline bool conv_nothing(const lt_conv2d_params *p)
{
    return p->n < 1 || p->c < 1 || p->o < 1 || lt_conv2d_out_h(p) < 1 || lt_conv2d_out_w(p) < 1
           || (int64_t)p->kh * p->kw > LT_CONV_MOST_TAPS;
}

/* The taps of the window, and where their weights stand. */
typedef struct { lt_tap at[LT_CONV_MOST_TAPS]; int weight[LT_CONV_MOST_TAPS]; int n; } conv_taps;

static inline void conv_window_taps(conv_taps *t, const lt_conv2d_params *p)
{
    t->n = 0;
    for (int ky = 0; ky < p->kh; ky++)
        for (int kx = 0; kx < p->kw; kx++) {
            t->at[t->n] = (lt_tap){ ky * p->dil_h - p->pad_h, kx * p->dil_w - p->pad_w };
            t->weight[t->n] = t->n;
            t->n++;
        }
}

/* How the window of output position (row, column) lies on x. */
static inline lt_conv_image conv_window_image(const lt_conv2d_params *p, const lt_real *x, const conv_taps *t)
{
    const lt_conv_image g = {
        .x = x, .h = p->h, .w = p->w, .grid_w = lt_conv2d_out_w(p),
        .step_h = p->stride_h, .step_w = p->stride_w, .taps = t->n, .tap = t->at,
    };
    return g;
}

/* What follows the sums of the panel of `columns` outputs from o on, with results in blocks, y's from y + at on.
 * bias: room for a panel's, of outputs that are not there 0. */
static inline lt_epilogue conv_panel_epilogue(const lt_conv2d_params *p, const lt_conv2d_around *around, int64_t o,
                                              int64_t columns, int64_t at, lt_real *bias)
{
    for (int64_t i = 0; around->bias && i < columns; i++)
        bias[i] = o + i < p->o ? around->bias[o + i] : 0;
    return (lt_epilogue){
        .col_bias = around->bias ? bias : NULL, .act = around->act,
        .residual = around->residual ? around->residual + at : NULL,
    };
}

/* ---- a convolution as a product over the maps: job.c ---- */

/* A matrix made of the weights: element (row, (channel, tap)) is w[row' + channel' + tap[tap]], where
 * the dashes mean times the step; with `whole` that is w[row' + column'] in a column of its own step. */
typedef struct {
    const lt_real *w;
    int64_t row, channel;
    int taps;
    const int *tap;
    bool whole;
    int64_t column;
} conv_matrix;

/* What the tasks of one product over the maps share; one group at a time. */
typedef struct {
    const lt_conv2d_params *p;
    lt_product product;                 /* its ctx is this */
    conv_matrix a;
    lt_conv_image image;                /* x: the first channel of image 0 of this group */
    int64_t image_step;                 /* between images */
    const lt_real *gate;                /* of image 0, or NULL */
    bool plain;                         /* 1 x 1, stride 1: the map is the matrix */
    int64_t m, n;                       /* rows, positions */
    int64_t tile_m, tile_n, tiles_m, tiles_n;
    int64_t images;                     /* that one task does */
} conv_job;

/**
 * conv_forward_job - the forward pass of one group, without its data, cut; t gets the window's taps
 * conv_run_rect    - of one image with weights in place, and of y only what r has: e follows the product and its own
 *                    epilogue
 * conv_direct_rect - lt_conv2d_forward_rect where the algorithm is LT_CONV_DIRECT or LT_CONV_TILES
 * All three are in direct.c.
 */
void conv_forward_job(conv_job *j, const lt_conv2d_params *p, conv_taps *t);
void conv_run_rect(conv_job *j, conv_taps *t, lt_rect r, const lt_real *x, const lt_epilogue *e, lt_real *y);
void conv_direct_rect(const lt_conv2d_params *p, lt_rect r, const lt_real *x, const lt_real *packed,
                      const lt_epilogue *e, lt_real *y);

/**
 * conv_suits_tiles - whether this CPU has AMX's tiles, and a convolution with so many positions enough to do for them
 * conv_on_tiles    - whether its product over the maps is best made by them: not where it is little more than writing
 * conv_forward_on_tiles - conv_on_tiles for the forward pass, where no other algorithm is better
 */
bool conv_suits_tiles(const lt_conv2d_params *p, int64_t positions);
bool conv_on_tiles(const lt_conv2d_params *p, int64_t m, int64_t n, int64_t k);
bool conv_forward_on_tiles(const lt_conv2d_params *p);

/* lt_product's pack_a, left, pack_b and right */
void conv_pack_weights(const void *ctx, lt_real *out, const lt_tile *t, int64_t k0, int64_t k);
void conv_left_weights(const void *ctx, lt_real *out, int64_t step, const lt_tile *t, int64_t k0, int64_t k);
void conv_pack_positions(const void *ctx, lt_real *out, const lt_tile *t, int64_t image, int64_t k0, int64_t k);
const lt_real *conv_right_positions(const void *ctx, lt_real *room, int64_t *ld, const lt_tile *t, int64_t image,
                                    int64_t k0, int64_t k);

enum { CONV_MOST_SHARED = 6 << 20 };    /* elements of maps that are packed before all tiles */

/**
 * conv_job_cut    - cut m x n into tiles, AMX's or not, and images into tasks
 * conv_job_packed - elements of the packed matrix
 * conv_job_tile   - tile (tm, tn)
 * conv_job_tasks  - of the product
 * conv_job_run    - one of them; for lt_parallel_for
 * conv_job_shared - where several tiles of rows read the same positions, all maps are packed once, before
 *                   them: elements for one image, or 0
 */
void conv_job_cut(conv_job *j, bool tiles);
int64_t conv_job_packed(const conv_job *j);
lt_tile conv_job_tile(const conv_job *j, int64_t tm, int64_t tn);
int64_t conv_job_tasks(const conv_job *j);
void conv_job_run(void *ctx, int64_t task);
int64_t conv_job_shared(const conv_job *j);

/* conv_data_on_tiles - conv_on_tiles for data_direct.c, the gradient of the input as products over dy */
bool conv_data_on_tiles(const lt_conv2d_params *p);

#endif
