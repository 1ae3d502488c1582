/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A convolution whose input is read as 8-bit integers: the direct one over maps of words, four channels of a pixel
 * each, with a fourth of the channels. All but the tile is what numbers go through.
 */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv_internal.h"
#include "libtensor/kernels/int8.h"
#include "libtensor/kernels/int8_weights.h"

#include <assert.h>

bool lt_conv2d_int8_suits(const lt_conv2d_params *p)
{
    return sizeof(lt_real) == INT8_WORD && p->groups == 1 && p->c >= INT8_LEAST_K
           && p->c * p->kh * p->kw <= INT8_MOST_K && !conv_nothing(p);
}

/* The same convolution over words. */
static lt_conv2d_params over_words(const lt_conv2d_params *p)
{
    lt_conv2d_params w = *p;

    w.c = int8_words(p->c);
    return w;
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
    conv_window_taps(&t, &words);
    conv_forward_job(&j, &words, &t);
    j.a.w = work;
    lt_product_pack_a(&j.product, j.m, j.tile_m, packed);
}

/* ---- the input ---------------------------------------------------------------------------------------- */

typedef struct {
    const lt_conv2d_params *p;
    const lt_int8_range *r;
    const lt_real *x, *gate;
    lt_real *words;
} input_job;

enum { STRETCH = 16384 };               /* elements of each map that a task makes words of */

static int64_t stretches(const lt_conv2d_params *p)
{
    return lt_ceil_div(p->h * p->w, STRETCH);
}

static void input_task(void *ctx, int64_t task)
{
    const input_job *j = ctx;
    const int64_t plane = j->p->h * j->p->w, words = int8_words(j->p->c), cuts = stretches(j->p);
    const int64_t at = task % cuts * STRETCH, word = task / cuts % words, image = task / cuts / words;
    const int64_t channel = image * j->p->c + word * INT8_WORD;
    const int64_t planes = lt_min_i64(INT8_WORD, j->p->c - word * INT8_WORD);

    lt_k->bytes_of_planes(j->words + (image * words + word) * plane + at, j->x + channel * plane + at, plane,
                          (int)planes, j->gate ? j->gate + channel : NULL, j->r,
                          (size_t)lt_min_i64(STRETCH, plane - at));
}

/* ---- forward ------------------------------------------------------------------------------------------ */

static int64_t input_words(const lt_conv2d_params *p)
{
    return lt_ceil_div(p->n * int8_words(p->c) * p->h * p->w, LT_ALIGN) * LT_ALIGN;
}

size_t lt_conv2d_int8_work(const lt_conv2d_params *p)
{
    const lt_conv2d_params words = over_words(p);
    conv_taps t;
    conv_job j;

    conv_window_taps(&t, &words);
    conv_forward_job(&j, &words, &t);
    return (size_t)(input_words(p) + conv_job_shared(&j) * p->n) * sizeof(lt_real);
}

void lt_conv2d_int8_forward(const lt_conv2d_params *p, const lt_int8_range *r, const lt_real *x, const lt_real *packed,
                            const lt_conv2d_around *around, lt_real *y, void *work)
{
    const lt_conv2d_params words = over_words(p);
    const lt_real *scale = packed + weight_words(p);
    const lt_bytes bytes = { .start = r->has_negative ? scale + p->o : NULL, .scale = scale, .flip = r->has_negative };
    lt_epilogue e = { .row_bias = around->bias, .residual = around->residual, .act = around->act };
    input_job in = { p, r, x, around->gate, work };
    conv_taps t;
    conv_job j;

    assert(!around->mean && (!around->gate || conv_pointwise(p)));
    conv_window_taps(&t, &words);
    conv_forward_job(&j, &words, &t);
    e.ld_residual = j.n;
    lt_parallel_for(p->n * words.c * stretches(p), input_task, &in);
    j.image = conv_window_image(&words, in.words, &t);
    j.product.a = packed;
    j.product.c = y;
    j.product.bytes = &bytes;
    j.product.e = &e;
    j.product.b_step = conv_job_shared(&j);
    if (j.product.b_step) {
        lt_real *shared = in.words + input_words(p);

        lt_product_pack_b(&j.product, p->n, j.n, j.tile_n, shared);
        j.product.b = shared;
    }
    lt_parallel_for(conv_job_tasks(&j), conv_job_run, &j);
}
