/* SPDX-License-Identifier: Apache-2.0 */
/* The gradients of a convolution's weights and bias. */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv_internal.h"
#include "libtensor/kernels/depthwise.h"
#include "libtensor/kernels/product.h"

enum { MOST_CHUNKS = 8 };               /* of a batch, each summed on its own */

typedef struct {
    const lt_conv2d_params *p;
    const lt_real *x, *dy;
    lt_real *dw, *part;                 /* part: one whole dw for each chunk of images */
    const conv_taps *t;
    int64_t chunks, tile_m, tile_n, tiles_m, tiles_n;
} weights_job;

typedef struct { const lt_real *dy; lt_conv_image x; int64_t positions; bool plain; } weights_ctx;

static int64_t chunk_count(const lt_conv2d_params *p)
{
    return lt_max_i64(1, lt_min_i64(p->n, MOST_CHUNKS));
}

size_t lt_conv2d_weights_work(const lt_conv2d_params *p)
{
    return (size_t)(chunk_count(p) * conv_weight_count(p)) * sizeof(lt_real);
}

static void pack_dy(const void *ctx, lt_real *out, const lt_tile *t, int64_t k0, int64_t k)
{
    const weights_ctx *c = ctx;

    lt_k->pack_a(out, c->dy + t->m0 * c->positions + k0, c->positions, 1, t->m, k);
}

static void pack_x(const void *ctx, lt_real *out, const lt_tile *t, int64_t image, int64_t k0, int64_t k)
{
    const weights_ctx *c = ctx;

    (void)image;
    if (c->plain)
        lt_k->pack_b(out, c->x.x + t->n0 * c->positions + k0, 1, c->positions, k, t->n);
    else
        lt_k->pack_image_t(out, &c->x, k0, k, t->n0, t->n);
}

static void run_weights(void *ctx, int64_t task)
{
    const weights_job *j = ctx;
    const lt_conv2d_params *p = j->p;
    const int64_t cg = conv_group_c(p), og = conv_group_o(p), n = cg * j->t->n;
    const int64_t out = lt_conv2d_out_h(p) * lt_conv2d_out_w(p);
    const int64_t tm = task % j->tiles_m, tn = task / j->tiles_m % j->tiles_n;
    const int64_t g = task / j->tiles_m / j->tiles_n % p->groups;
    const int64_t chunk = task / j->tiles_m / j->tiles_n / p->groups;
    const int64_t from = chunk * p->n / j->chunks, to = (chunk + 1) * p->n / j->chunks;
    const lt_tile t = {
        tm * j->tile_m, lt_min_i64(j->tile_m, og - tm * j->tile_m),
        tn * j->tile_n, lt_min_i64(j->tile_n, n - tn * j->tile_n),
    };

    for (int64_t i = from; i < to; i++) {
        const weights_ctx c = {
            j->dy + (i * p->o + g * og) * out,
            conv_window_image(p, j->x + (i * p->c + g * cg) * p->h * p->w, j->t), out, conv_pointwise(p),
        };
        const lt_product product = {
            .k = out, .ctx = &c, .pack_a = pack_dy, .pack_b = pack_x,
            .c = j->part + chunk * conv_weight_count(p) + (g * og + t.m0) * n + t.n0, .ldc = n,
            .add = i > from,
        };

        lt_product_tile(&product, &t, 0, 1);
    }
}

enum { RUN = 4096 };

static void add_chunks(void *ctx, int64_t task)
{
    const weights_job *j = ctx;
    const int64_t n = conv_weight_count(j->p), at = task * RUN;

    for (int64_t i = 0; i < j->chunks; i++)
        lt_k->add_to(j->dw + at, j->part + i * n + at, (size_t)lt_min_i64(RUN, n - at));
}

void lt_conv2d_backward_weights(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy,
                                lt_real *dw, void *work)
{
    conv_taps t;

    if (conv_nothing(p))
        return;
    conv_window_taps(&t, p);
    weights_job j = { p, x, dy, dw, work, &t, chunk_count(p), 0, 0, 0, 0 };
    const int64_t n = conv_group_c(p) * t.n;

    j.tile_m = lt_tile_size(conv_group_o(p), LT_TILE_M, 1);
    j.tile_n = lt_tile_size(n, 256, 64);
    j.tiles_m = lt_ceil_div(conv_group_o(p), j.tile_m);
    j.tiles_n = lt_ceil_div(n, j.tile_n);
    if (conv_group_c(p) == 1)
        lt_depthwise_backward_weights(p, x, dy, j.chunks, work);
    else
        lt_parallel_for(j.tiles_m * j.tiles_n * p->groups * j.chunks, run_weights, &j);
    lt_parallel_for(lt_ceil_div(conv_weight_count(p), RUN), add_chunks, &j);
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
