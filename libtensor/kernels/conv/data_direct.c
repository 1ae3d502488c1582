/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gradient of a convolution's input as products over dy.
 *
 * Input rows y = first + stride * i see a tap ky only where y + pad - ky * dil is a multiple of the stride, and then
 * read row i + (first + pad - ky * dil) / stride of dy. So the rows and columns fall into stride x stride classes, each
 * a product with stride 1 of its own. All classes have as many positions as the first, some of them beyond the map.
 */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/internal.h"
#include "libtensor/kernels/conv/way.h"

#include <string.h>

/* A class, first row and column; its weights are packed behind those of the class before, and its maps where tiles of
 * rows share those */
typedef struct {
    conv_job j;
    int y0, x0;
    int64_t packed_at, maps_at;
} data_class;

static bool strided(const lt_conv2d_params *p)
{
    return p->stride_h > 1 || p->stride_w > 1;
}

static int64_t class_rows(const lt_conv2d_params *p)
{
    return lt_ceil_div(p->h, p->stride_h);
}

static int64_t class_cols(const lt_conv2d_params *p)
{
    return lt_ceil_div(p->w, p->stride_w);
}

bool conv_data_on_tiles(const lt_conv2d_params *p)
{
    return conv_on_tiles(p, p->c, class_rows(p) * class_cols(p), p->o * p->kh * p->kw);
}

/* ---- classes ------------------------------------------------------------------------------------------- */

static void class_taps(conv_taps *t, const lt_conv2d_params *p, int y0, int x0)
{
    t->n = 0;
    for (int ky = 0; ky < p->kh; ky++) {
        const int dy = y0 + p->pad_h - ky * p->dil_h;

        for (int kx = 0; kx < p->kw && dy % p->stride_h == 0; kx++) {
            const int dx = x0 + p->pad_w - kx * p->dil_w;

            if (dx % p->stride_w)
                continue;
            t->at[t->n] = (lt_tap){ dy / p->stride_h, dx / p->stride_w };
            t->weight[t->n] = ky * p->kw + kx;
            t->n++;
        }
    }
}

/* Room for what a task makes of a class, before it goes to its places between those of other classes */
enum { SPREAD_M = LT_PRODUCT_TILES_M, SPREAD_N = LT_PRODUCT_TILES_N };

static void cut_spread(conv_job *j)
{
    const bool tiles = j->product.left;

    j->images = lt_max_i64(1, lt_min_i64(j->p->n, SPREAD_N / j->n));
    j->tile_m = lt_tile_size(j->m, tiles ? SPREAD_M : 64, tiles ? LT_TILES_SIDE : 1);
    j->tile_n = lt_tile_size(j->n, SPREAD_N, tiles ? LT_TILES_SIDE : 64);
    j->tiles_m = lt_ceil_div(j->m, j->tile_m);
    j->tiles_n = lt_ceil_div(j->n, j->tile_n);
}

/* The product of one class of one group, without its data. */
static void class_job(conv_job *j, const lt_conv2d_params *p, const conv_taps *t)
{
    const int64_t cg = conv_group_c(p), og = conv_group_o(p), k_all = (int64_t)p->kh * p->kw;
    const int64_t out_h = lt_conv2d_out_h(p), out_w = lt_conv2d_out_w(p);
    const int64_t rows = class_rows(p), cols = class_cols(p);
    const bool as_it_is = t->n == 1 && !t->at[0].dy && !t->at[0].dx;

    *j = (conv_job){
        .p = p, .m = cg, .n = rows * cols, .plain = as_it_is && rows == out_h && cols == out_w,
        .image_step = p->o * out_h * out_w,
        .a = { NULL, k_all, cg * k_all, t->n, t->weight, k_all == 1, cg },
        .image = { NULL, out_h, out_w, cols, 1, 1, t->n, t->at },
        .product = {
            .k = og * t->n, .pack_a = conv_pack_weights, .pack_b = conv_pack_positions, .ctx = j,
            .ldc = p->h * p->w, .c_step = p->c * p->h * p->w,
        },
    };
    conv_job_cut(j, conv_data_on_tiles(p));
    if (strided(p))
        cut_spread(j);
}

typedef void (*class_fn)(data_class *c, void *ctx);

/* Those without taps as well */
static void each_class(const lt_conv2d_params *p, class_fn fn, void *ctx)
{
    data_class c = { .packed_at = 0 };
    conv_taps t;

    for (c.y0 = 0; c.y0 < p->stride_h && c.y0 < p->h; c.y0++)
        for (c.x0 = 0; c.x0 < p->stride_w && c.x0 < p->w; c.x0++) {
            class_taps(&t, p, c.y0, c.x0);
            class_job(&c.j, p, &t);
            fn(&c, ctx);
            c.packed_at += p->groups * conv_job_packed(&c.j);
            c.maps_at += p->n * conv_job_shared(&c.j);
        }
}

/* ---- what is packed ------------------------------------------------------------------------------------ */

typedef struct { int64_t packed, maps; } sizes;

static void measure_class(data_class *c, void *ctx)
{
    sizes *s = ctx;

    s->packed = c->packed_at + c->j.p->groups * conv_job_packed(&c->j);
    s->maps = c->maps_at + c->j.p->n * conv_job_shared(&c->j);
}

static sizes measure(const lt_conv2d_params *p)
{
    sizes s = { 0 };

    each_class(p, measure_class, &s);
    if (s.maps > CONV_MOST_SHARED)
        s.maps = 0;
    return s;
}

typedef struct { const lt_real *weights; lt_real *packed; } weights_pass;

static void pack_class(data_class *c, void *ctx)
{
    const weights_pass *pass = ctx;
    const int64_t groups = c->j.p->groups, each = conv_weight_count(c->j.p) / groups;
    lt_real *packed = pass->packed + c->packed_at;

    for (int64_t g = 0; g < groups && c->j.a.taps; g++, packed += conv_job_packed(&c->j)) {
        c->j.a.w = pass->weights + g * each;
        lt_product_pack_a(&c->j.product, c->j.m, c->j.tile_m, packed);
    }
}

static int64_t packed_elements(const lt_conv2d_params *p, conv_direction d)
{
    (void)d;
    return measure(p).packed;
}

static void pack(const lt_conv2d_params *p, conv_direction d, const lt_real *weights, lt_real *packed)
{
    (void)d;
    each_class(p, pack_class, &(weights_pass){ weights, packed });
}

static size_t work_bytes(const lt_conv2d_params *p, conv_direction d)
{
    (void)d;
    return (size_t)measure(p).maps * sizeof(lt_real);
}

/* ---- one group ----------------------------------------------------------------------------------------- */

typedef struct {
    const lt_conv2d_params *p;
    int64_t group;
    const lt_real *dy, *packed;         /* dy and dx: of the group */
    lt_real *dx, *maps;                 /* maps: NULL where they are not shared */
    bool add;
} data_pass;

static void give_data(data_class *c, const data_pass *pass)
{
    c->j.image.x = pass->dy;
    c->j.product.a = pass->packed + c->packed_at + pass->group * conv_job_packed(&c->j);
    c->j.product.b_step = pass->maps ? conv_job_shared(&c->j) : 0;
    c->j.product.b = c->j.product.b_step ? pass->maps + c->maps_at : NULL;
    c->j.product.b_columns = c->j.n;
}

static void share_maps(data_class *c, void *ctx)
{
    const data_pass *pass = ctx;

    give_data(c, pass);
    c->j.product.b = NULL;
    if (c->j.product.b_step)
        lt_product_pack_b(&c->j.product, pass->p->n, c->j.n, c->j.tile_n, pass->maps + c->maps_at);
}

/* Without a stride there is one class, and its places are all of dx. */
static void run_in_place(data_class *c, void *ctx)
{
    const data_pass *pass = ctx;

    give_data(c, pass);
    c->j.product.c = pass->dx;
    c->j.product.add = pass->add;
    lt_parallel_for(conv_job_tasks(&c->j), conv_job_run, &c->j);
}

/* ---- with a stride: a task makes all classes of some places of dx --------------------------------------- */

typedef struct {
    const data_pass *pass;
    int64_t task;
} piece;

/* `run` columns of a class from (row, col) on to their places in a map; with NULL zeros, there and between them. */
static void put_run(const data_class *c, lt_real *map, int64_t row, int64_t col, int64_t run, const lt_real *made)
{
    const lt_conv2d_params *p = c->j.p;
    const int64_t y = c->y0 + row * p->stride_h, x = col * p->stride_w;
    lt_real *line;

    if (y >= p->h)
        return;
    line = map + y * p->w + x;
    if (made)
        lt_k->axpy_out(line + c->x0, p->stride_w, 1, made,
                       (size_t)lt_min_i64(run, lt_ceil_div(p->w - x - c->x0, p->stride_w)));
    else
        memset(line, 0, (size_t)lt_min_i64(run * p->stride_w, p->w - x) * sizeof(*line));
}

static void put_tile(const data_class *c, const lt_tile *t, lt_real *dx, const lt_real *made)
{
    const lt_conv2d_params *p = c->j.p;
    const int64_t cols = class_cols(p), row0 = t->n0 / cols, col0 = t->n0 % cols;

    for (int64_t i = 0; i < t->m; i++)
        for (int64_t q = 0, run, row = row0, col = col0; q < t->n; q += run, row++, col = 0) {
            run = lt_min_i64(t->n - q, cols - col);
            put_run(c, dx + (t->m0 + i) * p->h * p->w, row, col, run, made ? made + i * SPREAD_N + q : NULL);
        }
}

/* Rows of dx are cleared before their first class; the rest finds them in the cache. */
static void spread_class(data_class *c, void *ctx)
{
    const piece *s = ctx;
    const lt_conv2d_params *p = s->pass->p;
    conv_job *j = &c->j;
    const lt_tile t = conv_job_tile(j, s->task % j->tiles_m, s->task / j->tiles_m % j->tiles_n);
    const int64_t from = s->task / j->tiles_m / j->tiles_n * j->images, n = lt_min_i64(j->images, p->n - from);
    lt_real *dx = s->pass->dx + from * p->c * p->h * p->w;
    _Alignas(LT_ALIGN) lt_real made[SPREAD_M * SPREAD_N];

    give_data(c, s->pass);
    for (int64_t i = 0; i < n && c->x0 == 0 && !s->pass->add; i++)
        put_tile(c, &t, dx + i * p->c * p->h * p->w, NULL);
    if (!j->a.taps)
        return;
    j->image.x += from * j->image_step;
    if (j->product.b)
        j->product.b += from * j->product.b_step;
    j->product.c = made;
    j->product.ldc = SPREAD_N;
    j->product.c_step = j->n;
    lt_product_tile(&j->product, &t, 0, n);
    for (int64_t i = 0; i < n; i++)
        put_tile(c, &t, dx + i * p->c * p->h * p->w, made + i * j->n);
}

static void run_piece(void *ctx, int64_t task)
{
    const data_pass *pass = ctx;

    each_class(pass->p, spread_class, &(piece){ pass, task });
}

static void count_tasks(data_class *c, void *ctx)
{
    *(int64_t *)ctx = conv_job_tasks(&c->j);
}

static void run(const lt_conv2d_params *p, conv_direction d, const lt_real *dy, const lt_real *packed,
                const lt_conv2d_around *around, lt_real *dx, void *work)
{
    const int64_t out = lt_conv2d_out_h(p) * lt_conv2d_out_w(p);
    lt_real *maps = measure(p).maps ? work : NULL;
    int64_t tasks = 0;

    (void)d;
    each_class(p, count_tasks, &tasks);
    for (int64_t g = 0; g < p->groups; g++) {
        data_pass pass = {
            .p = p, .group = g, .dy = dy + g * conv_group_o(p) * out, .packed = packed,
            .dx = dx + g * conv_group_c(p) * p->h * p->w, .maps = maps, .add = around->residual,
        };

        if (pass.maps)
            each_class(p, share_maps, &pass);
        if (strided(p))
            lt_parallel_for(tasks, run_piece, &pass);
        else
            each_class(p, run_in_place, &pass);
    }
}

const conv_way conv_data_direct = { packed_elements, pack, work_bytes, run };
