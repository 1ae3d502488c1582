/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/blocks/depthwise.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/gemm/product.h"

#include <string.h>

enum {
    POSITIONS = 512,            /* of x, at a time, about */
    BANDS = 8,                  /* of a map */
};

static int64_t room_of(const lt_conv2d_params *p)
{
    return lt_max_i64(p->kh + p->stride_h, POSITIONS / (p->w + 2 * p->pad_w));
}

bool lt_depthwise_blocks_suits(const lt_conv2d_params *p)
{
    return (p->kh == 3 || p->kh == 5) && p->stride_h <= 2 && p->pad_h < p->kh && p->dil_h == 1 && p->dil_w == 1
           && room_of(p) * (p->w + 2 * p->pad_w) * LT_BLOCK <= LT_SCRATCH_B;
}

/* ---- weights: [block][tap][LT_BLOCK] ---------------------------------------------------------------------- */

int64_t lt_depthwise_blocks_packed(const lt_conv2d_params *p)
{
    return lt_blocks_of(p->c) * p->kh * p->kw * LT_BLOCK;
}

void lt_depthwise_blocks_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    const int64_t taps = (int64_t)p->kh * p->kw;

    memset(packed, 0, (size_t)lt_depthwise_blocks_packed(p) * sizeof(lt_real));
    for (int64_t c = 0; c < p->c; c++)
        for (int64_t t = 0; t < taps; t++)
            packed[(c / LT_BLOCK * taps + t) * LT_BLOCK + c % LT_BLOCK] = weights[c * taps + t];
}

/* ---- some rows of one block --------------------------------------------------------------------------------- */

depthwise_blocks depthwise_blocks_cut(const lt_conv2d_params *p, int64_t bands)
{
    depthwise_blocks j = { .p = p, .out_h = lt_conv2d_out_h(p), .blocks = lt_blocks_of(p->c), .room = room_of(p) };

    j.band = lt_ceil_div(j.out_h, lt_max_i64(1, lt_min_i64(bands, j.out_h)));
    j.bands = lt_ceil_div(j.out_h, j.band);
    j.rows = (j.room - p->kh) / p->stride_h + 1;
    j.window = (lt_blocks_window){
        .h = p->h, .wide = p->w + 2 * p->pad_w, .out_w = lt_conv2d_out_w(p), .size = p->kh, .step = p->stride_h,
        .pad = p->pad_h,
    };
    return j;
}

size_t depthwise_blocks_sums(const depthwise_blocks *j)
{
    return (size_t)(j->p->n * j->bands * j->blocks * LT_BLOCK) * sizeof(double);
}

/* Where a place's sums are; zeros before the first of its rows */
static double *sums_at(const depthwise_blocks *j, const depthwise_place *at, bool first)
{
    double *sum = j->sums + ((at->image * j->bands + at->band) * j->blocks + at->block) * LT_BLOCK;

    if (first)
        memset(sum, 0, LT_BLOCK * sizeof(*sum));
    return sum;
}

void depthwise_blocks_rows(const depthwise_blocks *j, const depthwise_place *at, const lt_real *x, int64_t first,
                           int64_t from, int64_t to)
{
    const lt_conv2d_around *around = j->around;
    const int64_t map = (at->image * j->blocks + at->block) * j->out_h * j->window.out_w * LT_BLOCK;
    const int64_t lanes = lt_min_i64(LT_BLOCK, j->p->c - at->block * LT_BLOCK), taps = (int64_t)j->p->kh * j->p->kw;
    _Alignas(LT_ALIGN) lt_real bias[LT_BLOCK] = { 0 };
    const lt_blocks_tail tail = {
        .bias = around->bias ? bias : NULL, .residual = around->residual ? around->residual + map : NULL,
        .act = around->act, .sum = around->mean ? sums_at(j, at, from == at->band * j->band) : NULL,
    };
    lt_blocks_window window = j->window;

    window.first = first;
    for (int64_t i = 0; around->bias && i < lanes; i++)
        bias[i] = around->bias[at->block * LT_BLOCK + i];
    lt_k->depthwise_block(j->y + map, x, j->packed + at->block * taps * LT_BLOCK, &window, from, to, &tail);
}

/* The means of one image's block */
static void mean_of_block(const depthwise_blocks *j, int64_t image, int64_t block)
{
    const double *sums = j->sums + (image * j->bands * j->blocks + block) * LT_BLOCK;
    const int64_t lanes = lt_min_i64(LT_BLOCK, j->p->c - block * LT_BLOCK);
    lt_real *mean = j->around->mean + image * j->p->c + block * LT_BLOCK;

    for (int64_t i = 0; i < lanes; i++) {
        double sum = 0;

        for (int64_t b = 0; b < j->bands; b++)
            sum += sums[b * j->blocks * LT_BLOCK + i];
        mean[i] = (lt_real)(sum / (double)(j->out_h * j->window.out_w));
    }
}

void depthwise_blocks_mean(const depthwise_blocks *j)
{
    for (int64_t image = 0; j->around->mean && image < j->p->n; image++)
        for (int64_t block = 0; block < j->blocks; block++)
            mean_of_block(j, image, block);
}

/* ---- alone: rows are copied, with their zeros ----------------------------------------------------------------- */

typedef struct { depthwise_blocks d; const lt_real *x; } job;
typedef struct { const job *j; depthwise_place at; } band;

static void copy_rows(const band *t, lt_real *out, int64_t from, int64_t to)
{
    const depthwise_blocks *d = &t->j->d;
    const int64_t w = d->p->w, pad = d->window.pad;
    const size_t side = (size_t)(pad * LT_BLOCK) * sizeof(*out), inner = (size_t)(w * LT_BLOCK) * sizeof(*out);
    const lt_real *row = t->j->x + ((t->at.image * d->blocks + t->at.block) * d->window.h + from) * w * LT_BLOCK;

    for (; from < to; from++, row += w * LT_BLOCK, out += d->window.wide * LT_BLOCK) {
        memset(out, 0, side);
        memcpy(out + pad * LT_BLOCK, row, inner);
        memset(out + (pad + w) * LT_BLOCK, 0, side);
    }
}

static void run_band(void *ctx, lt_real *unused, lt_real *rows)
{
    const band *t = ctx;
    const depthwise_blocks *d = &t->j->d;
    const int64_t end = lt_min_i64((t->at.band + 1) * d->band, d->out_h);

    (void)unused;
    for (int64_t from = t->at.band * d->band, to; from < end; from = to) {
        const int64_t first = depthwise_blocks_first_row(d, from);

        to = lt_min_i64(from + d->rows, end);
        copy_rows(t, rows, first, depthwise_blocks_end_row(d, to - 1));
        depthwise_blocks_rows(d, &t->at, rows, first, from, to);
    }
}

static void run_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const depthwise_blocks *d = &j->d;
    band t = { j, { task / d->blocks / d->bands, task / d->blocks % d->bands, task % d->blocks } };

    lt_with_scratch(run_band, &t);
}

/* Bands of as many rows as there is room for, or more where there would be many. */
static depthwise_blocks plan(const lt_conv2d_params *p)
{
    const depthwise_blocks whole = depthwise_blocks_cut(p, 1);

    return depthwise_blocks_cut(p, lt_min_i64(BANDS, lt_ceil_div(whole.out_h, whole.rows)));
}

size_t lt_depthwise_blocks_work(const lt_conv2d_params *p)
{
    const depthwise_blocks d = plan(p);

    return depthwise_blocks_sums(&d);
}

void lt_depthwise_blocks_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                                 const lt_conv2d_around *around, lt_real *y, void *work)
{
    job j = { plan(p), x };

    j.d.packed = packed, j.d.around = around, j.d.y = y, j.d.sums = work;
    lt_parallel_for(p->n * j.d.bands * j.d.blocks, run_task, &j);
    depthwise_blocks_mean(&j.d);
}
