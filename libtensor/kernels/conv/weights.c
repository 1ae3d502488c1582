/* SPDX-License-Identifier: Apache-2.0 */
/* The gradients of a convolution's weights and bias. */
#include "libtensor/kernels/conv/weights.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/depthwise.h"
#include "libtensor/kernels/conv/winograd_weights.h"

#include <string.h>

enum {
    MOST_CHUNKS = 8,                    /* of a batch, each summed on its own ... */
    FEW_TASKS = 16,                     /* ... where its tiles alone are fewer than this */
};

/* ---- cutting ------------------------------------------------------------------------------------------- */

static bool strided_samples(const lt_conv2d_params *p)
{
    return p->kh == 1 && p->kw == 1 && !conv_pointwise(p);
}

static void set_sizes(weights_job *j)
{
    const lt_conv2d_params *p = &j->p;
    const int64_t cg = conv_group_c(p), og = conv_group_o(p), unit = (int64_t)p->kh * p->kw;

    j->m = cg * unit, j->n = og;
    if (j->tiles) {
        j->swapped = unit == 1 && cg > og;
        j->m = j->swapped ? cg : og, j->n = j->swapped ? og : cg * unit;
        j->tile_m = lt_tile_size(j->m, LT_PRODUCT_TILES_M, LT_TILES_SIDE);
        j->tile_n = lt_tile_size(j->n, LT_PRODUCT_TILES_N, LT_TILES_SIDE);
    } else if (j->way == BY_WINDOW) {
        j->tile_m = lt_tile_size(cg, LT_WEIGHTS_CHANNELS, 1) * unit;
        j->tile_n = lt_tile_size(j->n, LT_WEIGHTS_LANES, 64);
    } else {
        j->m = og, j->n = cg * unit;
        j->tile_m = lt_tile_size(j->m, LT_TILE_M, 1);
        j->tile_n = lt_tile_size(j->n, 256, 64);
    }
}

static void cut(weights_job *j)
{
    enum { MANY = 128 };                /* channels of x, for which windows are worth turning */
    const lt_conv2d_params *p = &j->p;

    conv_window_taps(&j->taps, p);
    j->positions = lt_conv2d_out_h(p) * lt_conv2d_out_w(p);
    j->tiles = (j->taps.n == 1 || p->c >= MANY) && conv_suits_tiles(p, j->positions);
    j->band = j->tiles ? (window_band){ 0 } : conv_weights_band(p);
    j->way = j->band.rows ? BY_WINDOW : strided_samples(p) ? BY_SAMPLES : BY_PRODUCT;
    set_sizes(j);
    j->tiles_m = lt_ceil_div(j->m, j->tile_m);
    j->tiles_n = lt_ceil_div(j->n, j->tile_n);
    j->pieces = j->tiles_m * j->tiles_n * p->groups;
    j->chunks = lt_min_i64(lt_ceil_div(FEW_TASKS, j->pieces), lt_min_i64(MOST_CHUNKS, p->n));
}

/* ---- 1 x 1 with a stride: what it reads of x, as maps of their own --------------------------------------- */

static int64_t sample_count(const lt_conv2d_params *p)
{
    return p->n * p->c * lt_conv2d_out_h(p) * lt_conv2d_out_w(p);
}

typedef struct { const weights_job *j; lt_real *out; } sample_job;

static void sample_channel(void *ctx, int64_t channel)
{
    const sample_job *s = ctx;
    const weights_job *j = s->j;
    const lt_conv_image g = conv_window_image(&j->p, j->x, &j->taps);
    lt_real line[LT_PACK_K + LT_WEIGHTS_SLACK];

    for (int64_t at = 0; at < j->positions; at += LT_PACK_K) {
        const int64_t n = lt_min_i64(LT_PACK_K, j->positions - at);

        lt_k->image_rows(line, 0, &g, at, n, channel, 1);
        memcpy(s->out + channel * j->positions + at, line, (size_t)n * sizeof(*line));
    }
}

static void by_samples(weights_job *j)
{
    sample_job s = { j, j->part };

    lt_parallel_for(j->p.n * j->p.c, sample_channel, &s);
    j->x = s.out;
    j->part = s.out + sample_count(&j->p);
    j->p.h = lt_conv2d_out_h(&j->p), j->p.w = lt_conv2d_out_w(&j->p);
    j->p.stride_h = j->p.stride_w = 1, j->p.pad_h = j->p.pad_w = 0;
    conv_weights_by_product(j);
}

/* ---- the gradient of the weights ------------------------------------------------------------------------ */

static int64_t depthwise_chunks(const lt_conv2d_params *p)
{
    return lt_min_i64(p->n, MOST_CHUNKS);
}

static int64_t work_elements(const weights_job *j)
{
    const int64_t samples = j->way == BY_SAMPLES ? sample_count(&j->p) : 0;

    if (j->way == BY_WINDOW)
        return j->pieces * j->chunks * j->tile_m * j->tile_n;
    return samples + (j->chunks > 1 || j->swapped ? j->chunks * conv_weight_count(&j->p) : 0);
}

size_t lt_conv2d_weights_work(const lt_conv2d_params *p)
{
    weights_job j = { .p = *p };

    if (conv_nothing(p))
        return 0;
    if (conv_group_c(p) == 1)
        return (size_t)(depthwise_chunks(p) * conv_weight_count(p)) * sizeof(lt_real);
    if (lt_winograd_weights_suits(p))
        return lt_winograd_weights_work(p);
    cut(&j);
    return (size_t)work_elements(&j) * sizeof(lt_real);
}

void lt_conv2d_backward_weights(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy, bool add,
                                lt_real *dw, void *work)
{
    weights_job j = { .p = *p, .x = x, .dy = dy, .add = add, .dw = dw, .part = work };

    if (conv_nothing(p)) {
        if (!add)
            memset(dw, 0, (size_t)conv_weight_count(p) * sizeof(lt_real));
        return;
    }
    cut(&j);
    if (conv_group_c(p) == 1) {
        j.chunks = depthwise_chunks(p);
        lt_depthwise_backward_weights(p, x, dy, j.chunks, work);
        conv_weights_add_chunks(&j);
    } else if (lt_winograd_weights_suits(p)) {
        lt_winograd_weights_run(p, x, dy, add, dw, work);
    } else if (j.way == BY_WINDOW) {
        conv_weights_by_windows(&j);
    } else if (j.way == BY_SAMPLES) {
        by_samples(&j);
    } else {
        conv_weights_by_product(&j);
    }
}

/* ---- gradient of the bias ------------------------------------------------------------------------------ */

typedef struct { const lt_conv2d_params *p; const lt_real *dy; lt_real *dbias; } bias_job;

static void bias_channel(void *ctx, int64_t o)
{
    const bias_job *j = ctx;
    const int64_t out = lt_conv2d_out_h(j->p) * lt_conv2d_out_w(j->p);
    double total = 0;

    for (int64_t i = 0; i < j->p->n; i++)
        total += lt_k->sum(j->dy + (i * j->p->o + o) * out, (size_t)out);
    j->dbias[o] += (lt_real)total;
}

void lt_conv2d_backward_bias(const lt_conv2d_params *p, const lt_real *dy, lt_real *dbias)
{
    bias_job j = { p, dy, dbias };

    if (!conv_nothing(p))
        lt_parallel_for(p->o, bias_channel, &j);
}
