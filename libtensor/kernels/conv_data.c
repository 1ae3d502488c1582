/* SPDX-License-Identifier: Apache-2.0 */
/* The gradient of a convolution's input. */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv_internal.h"
#include "libtensor/kernels/conv_tapwise.h"
#include "libtensor/kernels/depthwise.h"
#include "libtensor/kernels/winograd.h"
#include "libtensor/kernels/winograd2.h"

#include <string.h>

/*
 * Input rows y = first + stride * i see a tap ky only where y + pad - ky * dil is a multiple of the
 * stride, and then read row i + (first + pad - ky * dil) / stride of dy. So the rows and columns fall
 * into stride x stride classes, each a product with stride 1 of its own.
 */
typedef struct { int y0, x0; int64_t rows, cols; } parity;

static int parity_taps(conv_taps *t, const lt_conv2d_params *p, parity c)
{
    t->n = 0;
    for (int ky = 0; ky < p->kh; ky++)
        for (int kx = 0; kx < p->kw; kx++) {
            const int dy = c.y0 + p->pad_h - ky * p->dil_h, dx = c.x0 + p->pad_w - kx * p->dil_w;

            if (dy % p->stride_h || dx % p->stride_w)
                continue;
            t->at[t->n] = (lt_tap){ dy / p->stride_h, dx / p->stride_w };
            t->weight[t->n] = ky * p->kw + kx;
            t->n++;
        }
    return t->n;
}

typedef struct { conv_job j; parity c; lt_real *dx; } data_job;

/* A class's tile, on its way to its strided places */
enum { SPREAD_M = LT_PRODUCT_TILES_M, SPREAD_N = LT_PRODUCT_TILES_N };

static void spread(const data_job *d, const lt_tile *t, int64_t image, const lt_real *tile)
{
    const lt_conv2d_params *p = d->j.p;

    for (int64_t i = 0; i < t->m; i++) {
        lt_real *plane = d->dx + image * p->c * p->h * p->w + (t->m0 + i) * p->h * p->w;

        for (int64_t q = 0; q < t->n;) {
            const int64_t row = (t->n0 + q) / d->c.cols, col = (t->n0 + q) % d->c.cols;
            const int64_t run = lt_min_i64(t->n - q, d->c.cols - col);
            lt_real *at = plane + (d->c.y0 + row * p->stride_h) * p->w + d->c.x0 + col * p->stride_w;

            lt_k->axpy_out(at, p->stride_w, 1, tile + i * SPREAD_N + q, (size_t)run);
            q += run;
        }
    }
}

static void run_spread(void *ctx, int64_t task)
{
    const data_job *d = ctx;
    const conv_job *j = &d->j;
    const lt_tile t = conv_job_tile(j, task % j->tiles_m, task / j->tiles_m % j->tiles_n);
    const int64_t image = task / j->tiles_m / j->tiles_n;
    _Alignas(LT_ALIGN) lt_real tile[SPREAD_M * SPREAD_N];
    lt_product product = j->product;

    product.c = tile;
    product.ldc = SPREAD_N;
    product.c_step = 0;
    lt_product_tile(&product, &t, image, image + 1);
    spread(d, &t, image, tile);
}

static void cut_spread(conv_job *j)
{
    const bool tiles = j->product.left;

    j->images = 1;
    j->tile_m = lt_tile_size(j->m, tiles ? SPREAD_M : 64, tiles ? LT_TILES_SIDE : 1);
    j->tile_n = lt_tile_size(j->n, SPREAD_N, tiles ? LT_TILES_SIDE : 64);
    j->tiles_m = lt_ceil_div(j->m, j->tile_m);
    j->tiles_n = lt_ceil_div(j->n, j->tile_n);
}

static bool strided(const lt_conv2d_params *p)
{
    return p->stride_h > 1 || p->stride_w > 1;
}

static bool as_it_is(const conv_taps *t)
{
    return t->n == 1 && !t->at[0].dy && !t->at[0].dx;
}

/* The product of one class of one group, without its data. */
static void class_job(data_job *d, const lt_conv2d_params *p, parity c, const conv_taps *t)
{
    const int64_t cg = conv_group_c(p), og = conv_group_o(p), k_all = (int64_t)p->kh * p->kw;
    const int64_t out_h = lt_conv2d_out_h(p), out_w = lt_conv2d_out_w(p);

    *d = (data_job){
        .c = c,
        .j = {
            .p = p, .m = cg, .n = c.rows * c.cols, .plain = as_it_is(t) && c.rows == out_h && c.cols == out_w,
            .image_step = p->o * out_h * out_w,
            .a = { NULL, k_all, cg * k_all, t->n, t->weight, k_all == 1, cg },
            .image = { NULL, out_h, out_w, c.cols, 1, 1, t->n, t->at },
            .product = {
                .k = og * t->n, .pack_a = conv_pack_weights, .pack_b = conv_pack_positions,
                .ctx = &d->j, .ldc = p->h * p->w, .c_step = p->c * p->h * p->w,
            },
        },
    };
    conv_job_cut(&d->j);
    if (strided(p))
        cut_spread(&d->j);
}

/* What goes from class to class; weights packed so far are behind packed. */
typedef struct {
    const lt_real *dy, *weights;
    lt_real *dx, *packed, *maps;        /* maps: of dy, packed where tiles share those */
    bool add;
    int64_t plane;                      /* elements of a map of dx */
    int64_t count, shared;              /* of packed weights; the most of maps */
} data_pass;

typedef void (*class_fn)(data_job *d, data_pass *pass);

static void measure_class(data_job *d, data_pass *pass)
{
    pass->count += d->j.p->groups * conv_job_packed(&d->j);
    pass->shared = lt_max_i64(pass->shared, conv_job_shared(&d->j) * d->j.p->n);
}

static void pack_class(data_job *d, data_pass *pass)
{
    conv_job *j = &d->j;
    const lt_conv2d_params *p = j->p;

    for (int64_t g = 0; g < p->groups; g++, pass->packed += conv_job_packed(j)) {
        j->a.w = pass->weights + g * conv_weight_count(p) / p->groups;
        lt_product_pack_a(&j->product, j->m, j->tile_m, pass->packed);
    }
}

static void run_class(data_job *d, data_pass *pass)
{
    conv_job *j = &d->j;
    const lt_conv2d_params *p = j->p;

    for (int64_t g = 0; g < p->groups; g++, pass->packed += conv_job_packed(j)) {
        d->dx = j->product.c = pass->dx + g * j->m * p->h * p->w;
        j->image.x = pass->dy + g * conv_group_o(p) * j->image.h * j->image.w;
        j->product.a = pass->packed;
        j->product.add = pass->add && !strided(p);
        j->product.b = NULL;
        j->product.b_step = conv_job_shared(j);
        if (j->product.b_step) {
            lt_product_pack_b(&j->product, p->n, j->n, j->tile_n, pass->maps);
            j->product.b = pass->maps;
        }
        lt_parallel_for(conv_job_tasks(j), strided(p) ? run_spread : conv_job_run, strided(p) ? (void *)d : j);
    }
}

static void each_class(const lt_conv2d_params *p, class_fn fn, data_pass *pass)
{
    conv_taps t;
    data_job d;

    for (int y0 = 0; y0 < p->stride_h && y0 < p->h; y0++)
        for (int x0 = 0; x0 < p->stride_w && x0 < p->w; x0++) {
            const parity c = { y0, x0, lt_ceil_div(p->h - y0, p->stride_h),
                               lt_ceil_div(p->w - x0, p->stride_w) };

            if (parity_taps(&t, p, c) == 0)
                continue;
            class_job(&d, p, c, &t);
            fn(&d, pass);
        }
}

/* With stride 1 and pad 1 a 3 x 3 window is its own transpose's: dy in the place of x. */
static void data_winograd(const lt_conv2d_params *p, const lt_real *dy, const lt_real *packed, bool add, lt_real *dx,
                          void *work)
{
    const lt_epilogue e = { .residual = add ? dx : NULL };

    lt_winograd_run(p, p->c, p->o, dy, packed, &e, dx, work);
}

static void clear_plane(void *ctx, int64_t plane)
{
    const data_pass *pass = ctx;

    memset(pass->dx + plane * pass->plane, 0, (size_t)pass->plane * sizeof(lt_real));
}

/* Strided classes add to their places in dx, and there may be places of none. */
static void data_direct(const lt_conv2d_params *p, data_pass *pass)
{
    pass->plane = p->h * p->w;
    if (strided(p) && !pass->add)
        lt_parallel_for(p->n * p->c, clear_plane, pass);
    each_class(p, run_class, pass);
}

/* Forward and this need not be alike: small maps of a strided convolution go tap by tap here. */
static lt_conv_algorithm algorithm(const lt_conv2d_params *p)
{
    const lt_conv_algorithm forward = lt_conv2d_algorithm(p);

    if (forward == LT_CONV_DEPTHWISE || forward == LT_CONV_WINOGRAD || forward == LT_CONV_WINOGRAD2)
        return forward;
    if (conv_on_tiles(p, p->c, p->h * p->w, p->o * p->kh * p->kw))
        return LT_CONV_TILES;
    return lt_tapwise_suits(p, LT_TAPWISE_DATA) ? LT_CONV_TAPWISE : LT_CONV_DIRECT;
}

int64_t lt_conv2d_data_packed(const lt_conv2d_params *p)
{
    data_pass pass = { .count = 0 };

    if (conv_nothing(p))
        return 0;
    switch (algorithm(p)) {
    case LT_CONV_WINOGRAD:
        return lt_winograd_packed(p->c, p->o);
    case LT_CONV_WINOGRAD2:
        return lt_winograd2_packed(p->c, p->o);
    case LT_CONV_TAPWISE:
        return lt_tapwise_packed(p, LT_TAPWISE_DATA);
    case LT_CONV_DEPTHWISE:
        return conv_weight_count(p);
    default:
        each_class(p, measure_class, &pass);
        return pass.count;
    }
}

void lt_conv2d_data_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    if (conv_nothing(p))
        return;
    switch (algorithm(p)) {
    case LT_CONV_DEPTHWISE:
        memcpy(packed, weights, (size_t)conv_weight_count(p) * sizeof(lt_real));
        break;
    case LT_CONV_WINOGRAD:
        lt_winograd_pack(weights, 9, p->c * 9, true, p->c, p->o, packed);
        break;
    case LT_CONV_WINOGRAD2:
        lt_winograd2_pack(weights, 9, p->c * 9, true, p->c, p->o, packed);
        break;
    case LT_CONV_TAPWISE:
        lt_tapwise_pack(p, LT_TAPWISE_DATA, weights, packed);
        break;
    default:
        each_class(p, pack_class, &(data_pass){ .weights = weights, .packed = packed });
        break;
    }
}

size_t lt_conv2d_backward_data_work(const lt_conv2d_params *p)
{
    data_pass pass = { .shared = 0 };

    if (conv_nothing(p))
        return 0;
    switch (algorithm(p)) {
    case LT_CONV_DEPTHWISE:
        return 0;
    case LT_CONV_WINOGRAD:
        return lt_winograd_work(p, p->c, p->o);
    case LT_CONV_WINOGRAD2:
        return lt_winograd2_work(p, p->c, p->o);
    case LT_CONV_TAPWISE:
        return lt_tapwise_work(p, LT_TAPWISE_DATA);
    default:
        each_class(p, measure_class, &pass);
        return (size_t)pass.shared * sizeof(lt_real);
    }
}

void lt_conv2d_backward_data(const lt_conv2d_params *p, const lt_real *dy, const lt_real *packed, bool add,
                             lt_real *dx, void *work)
{
    if (conv_nothing(p)) {
        if (!add)
            memset(dx, 0, (size_t)(p->n * p->c * p->h * p->w) * sizeof(lt_real));
        return;
    }
    switch (algorithm(p)) {
    case LT_CONV_DEPTHWISE:
        lt_depthwise_backward_data(p, dy, packed, add, dx);
        break;
    case LT_CONV_WINOGRAD:
        data_winograd(p, dy, packed, add, dx, work);
        break;
    case LT_CONV_WINOGRAD2:
        lt_winograd2_run(p, p->c, p->o, dy, packed, &(lt_conv2d_around){ .residual = add ? dx : NULL }, dx, work);
        break;
    case LT_CONV_TAPWISE:
        lt_tapwise_run(p, LT_TAPWISE_DATA, dy, packed, &(lt_conv2d_around){ 0 }, add, dx, work);
        break;
    default:
        data_direct(p, &(data_pass){ .dy = dy, .packed = (lt_real *)packed, .dx = dx, .maps = work, .add = add });
        break;
    }
}
