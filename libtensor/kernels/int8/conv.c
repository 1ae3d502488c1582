/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A convolution whose input is read as 8-bit integers: the direct one over maps of words, four channels of a pixel
 * each, with a fourth of the channels. All but the tile is what numbers go through.
 */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/internal.h"
#include "libtensor/kernels/int8/int8.h"
#include "libtensor/kernels/int8/weights.h"

#include <assert.h>

/* Words at least three quarters full: an image's three channels are enough. */
bool lt_conv2d_int8_suits(const lt_conv2d_params *p)
{
    const int64_t k = p->c * p->kh * p->kw;

    return sizeof(lt_real) == INT8_WORD && p->groups == 1 && p->c >= 3 * int8_words(p->c) && k >= INT8_LEAST_K
           && k <= INT8_MOST_K && !conv_nothing(p);
}

/* The same convolution over words. */
static lt_conv2d_params over_words(const lt_conv2d_params *p)
{
    lt_conv2d_params w = *p;

    w.c = int8_words(p->c);
    return w;
}

/* The product, cut into tiles of rows that are whole panels almost. */
static void word_job(conv_job *j, const lt_conv2d_params *words, conv_taps *t)
{
    int64_t panels;

    conv_forward_job(j, words, t);
    panels = lt_max_i64(1, j->tile_m / lt_k->mr);
    j->tiles_m = lt_ceil_div(lt_ceil_div(j->m, lt_k->mr), panels);
    j->tile_m = lt_ceil_div(j->m, j->tiles_m);
    j->tiles_m = lt_ceil_div(j->m, j->tile_m);
}

/* ---- weights: packed words, then the scale of each output, then what its sum starts from ---------------- */

static int64_t weight_words(const lt_conv2d_params *p)
{
    return p->o * int8_words(p->c) * p->kh * p->kw;
}

int64_t lt_conv2d_int8_packed(const lt_conv2d_params *p)
{
    return weight_words(p) + 2 * p->o;
}

size_t lt_conv2d_int8_pack_work(const lt_conv2d_params *p)
{
    return (size_t)weight_words(p) * sizeof(lt_real);
}

void lt_conv2d_int8_pack(const lt_conv2d_params *p, const lt_int8_range *r, const lt_real *weights, lt_real *packed,
                         void *work)
{
    const lt_conv2d_params words = over_words(p);
    lt_real *scale = packed + weight_words(p);
    conv_taps t;
    conv_job j;

    int8_weights(weights, p->o, p->c, (int64_t)p->kh * p->kw, r, work, scale, scale + p->o);
    word_job(&j, &words, &t);
    j.a.w = work;
    lt_product_pack_a(&j.product, j.m, j.tile_m, packed);
}

/* ---- the input: as words in a map of their own; pointwise, straight into panels -------------------------- */

typedef struct {
    conv_job j;
    const lt_conv2d_params *p;          /* of numbers */
    const lt_int8_range *r;
    const lt_real *x, *gate;
    lt_real *words;
} int8_job;

enum { STRETCH = 16384 };               /* elements of each map that a task makes words of */

static int64_t stretches(const lt_conv2d_params *p)
{
    return lt_ceil_div(p->h * p->w, STRETCH);
}

static void input_task(void *ctx, int64_t task)
{
    const int8_job *j = ctx;
    const int64_t plane = j->p->h * j->p->w, words = int8_words(j->p->c), cuts = stretches(j->p);
    const int64_t at = task % cuts * STRETCH, word = task / cuts % words, image = task / cuts / words;
    const int64_t channel = image * j->p->c + word * INT8_WORD;
    const int64_t planes = lt_min_i64(INT8_WORD, j->p->c - word * INT8_WORD);

    lt_k->bytes_of_planes(j->words + (image * words + word) * plane + at, j->x + channel * plane + at, plane,
                          (int)planes, NULL, j->r, (size_t)lt_min_i64(STRETCH, plane - at));
}

static void pack_words(const void *ctx, lt_real *out, const lt_tile *t, int64_t image, int64_t k0, int64_t k)
{
    const int8_job *j = ctx;

    conv_pack_positions(&j->j, out, t, image, k0, k);
    if (j->r->has_negative)
        lt_k->bytes_raise(out, (size_t)(lt_ceil_div(t->n, lt_k->nr) * lt_k->nr * k));
}

static void pack_numbers(const void *ctx, lt_real *out, const lt_tile *t, int64_t image, int64_t k0, int64_t k)
{
    const int8_job *j = ctx;
    const int64_t plane = j->p->h * j->p->w, from = k0 * INT8_WORD, channel = image * j->p->c + from;

    lt_k->bytes_of_panels(out, j->x + channel * plane + t->n0, plane, lt_min_i64(k * INT8_WORD, j->p->c - from),
                          j->gate ? j->gate + channel : NULL, j->r, t->n);
}

/* ---- forward ------------------------------------------------------------------------------------------ */

static int64_t input_words(const lt_conv2d_params *p)
{
    return conv_pointwise(p) ? 0 : lt_ceil_div(p->n * int8_words(p->c) * p->h * p->w, LT_ALIGN) * LT_ALIGN;
}

size_t lt_conv2d_int8_work(const lt_conv2d_params *p)
{
    const lt_conv2d_params words = over_words(p);
    conv_taps t;
    conv_job j;

    word_job(&j, &words, &t);
    return (size_t)(input_words(p) + conv_job_shared(&j) * p->n) * sizeof(lt_real);
}

static void make_words(int8_job *j, const lt_conv2d_params *words, const conv_taps *t)
{
    j->j.image = conv_window_image(words, j->words, t);
    j->j.product.ctx = j;
    j->j.product.pack_b = conv_pointwise(j->p) ? pack_numbers : pack_words;
    if (!conv_pointwise(j->p))
        lt_parallel_for(j->p->n * words->c * stretches(j->p), input_task, j);
}

void lt_conv2d_int8_forward(const lt_conv2d_params *p, const lt_int8_range *r, const lt_real *x, const lt_real *packed,
                            const lt_conv2d_around *around, lt_real *y, void *work)
{
    const lt_conv2d_params words = over_words(p);
    const lt_real *scale = packed + weight_words(p);
    const lt_bytes bytes = { .start = r->has_negative ? scale + p->o : NULL, .scale = scale };
    lt_epilogue e = { .row_bias = around->bias, .residual = around->residual, .act = around->act };
    int8_job j = { .p = p, .r = r, .x = x, .gate = around->gate, .words = work };
    lt_product *product = &j.j.product;
    conv_taps t;

    assert(!around->mean && (!around->gate || conv_pointwise(p)));
    word_job(&j.j, &words, &t);
    make_words(&j, &words, &t);
    e.ld_residual = j.j.n;
    product->a = packed;
    product->c = y;
    product->bytes = &bytes;
    product->e = &e;
    product->b_step = conv_job_shared(&j.j);
    if (product->b_step) {
        lt_real *shared = j.words + input_words(p);

        lt_product_pack_b(product, p->n, j.j.n, j.j.tile_n, shared);
        product->b = shared;
        product->b_columns = j.j.n;
    }
    lt_parallel_for(conv_job_tasks(&j.j), conv_job_run, &j.j);
}

/* ---- a part of one image ------------------------------------------------------------------------------ */

bool lt_conv2d_int8_takes_rect(const lt_conv2d_params *p)
{
    return p->stride_h == 1 && p->stride_w == 1;
}

size_t lt_conv2d_int8_rect_work(const lt_conv2d_params *p)
{
    return (size_t)(int8_words(p->c) * p->h * p->w) * sizeof(lt_real);
}

typedef struct { const int8_job *j; int64_t from, n; } rows_job;    /* elements of each map */

static void rows_task(void *ctx, int64_t word)
{
    const rows_job *rows = ctx;
    const int8_job *j = rows->j;
    const int64_t plane = j->p->h * j->p->w, channel = word * INT8_WORD;

    lt_k->bytes_of_planes(j->words + word * plane + rows->from, j->x + channel * plane + rows->from, plane,
                          (int)lt_min_i64(INT8_WORD, j->p->c - channel), NULL, j->r, (size_t)rows->n);
}

/* The rows of the map that the windows of these rows of y reach. */
static void make_rows(const int8_job *j, lt_rect r)
{
    const lt_conv2d_params *p = j->p;
    const int64_t first = lt_max_i64(0, r.y0 - p->pad_h);
    const int64_t end = lt_min_i64(p->h, r.y1 - p->pad_h + (int64_t)(p->kh - 1) * p->dil_h);
    rows_job rows = { j, first * p->w, lt_max_i64(0, end - first) * p->w };

    lt_parallel_for(int8_words(p->c), rows_task, &rows);
}

void lt_conv2d_int8_forward_rect(const lt_conv2d_params *p, const lt_int8_range *r, lt_rect rect, const lt_real *x,
                                 const lt_real *packed, const lt_real *bias, const lt_real *residual, lt_act act,
                                 lt_real *y, void *work)
{
    const lt_conv2d_params words = over_words(p);
    const lt_real *scale = packed + weight_words(p);
    const lt_bytes bytes = { .start = r->has_negative ? scale + p->o : NULL, .scale = scale };
    const lt_epilogue none = { .act = { .kind = LT_ACT_NONE } };
    const lt_epilogue e = { .row_bias = bias, .residual = residual, .act = act };
    int8_job j = { .p = p, .r = r, .x = x, .words = work };
    conv_taps t;

    if (rect.y0 >= rect.y1 || rect.x0 >= rect.x1)
        return;
    word_job(&j.j, &words, &t);
    make_rows(&j, rect);
    j.j.product.a = packed;
    j.j.product.bytes = &bytes;
    j.j.product.e = &none;
    j.j.product.ctx = &j;
    j.j.product.pack_b = pack_words;
    conv_run_rect(&j.j, &t, rect, j.words, &e, y);
}
