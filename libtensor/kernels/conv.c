/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv_internal.h"
#include "libtensor/kernels/depthwise.h"
#include "libtensor/kernels/product.h"
#include "libtensor/kernels/winograd.h"

#include <assert.h>
#include <string.h>

enum { MOST_SHARED = 6 << 20 };         /* elements of maps that are packed before all tiles */

/* A matrix made of the weights: element (row, (channel, tap)) is w[row' + channel' + tap[tap]], where
 * the dashes mean times the step; with `whole` that is w[row' + column'] in a column of its own step. */
typedef struct {
    const lt_real *w;
    int64_t row, channel;
    int taps;
    const int *tap;
    bool whole;
    int64_t column;
} weight_matrix;

/* What the tasks of one product over the maps share; one group at a time. */
typedef struct {
    const lt_conv2d_params *p;
    lt_product product;
    weight_matrix a;
    lt_conv_image image;                     /* x: the first channel of image 0 of this group */
    int64_t image_step;                 /* between images */
    const lt_real *gate;                /* of image 0, or NULL */
    bool plain;                         /* 1 x 1, stride 1: the map is the matrix */
    int64_t m, n;                       /* rows, positions */
    int64_t tile_m, tile_n, tiles_m, tiles_n;
    int64_t images;                     /* that one task does */
} job;

int64_t lt_conv2d_out_h(const lt_conv2d_params *p)
{
    return (p->h + 2 * p->pad_h - p->dil_h * (p->kh - 1) - 1) / p->stride_h + 1;
}

int64_t lt_conv2d_out_w(const lt_conv2d_params *p)
{
    return (p->w + 2 * p->pad_w - p->dil_w * (p->kw - 1) - 1) / p->stride_w + 1;
}

lt_rect lt_conv2d_all(const lt_conv2d_params *p)
{
    return (lt_rect){ 0, lt_conv2d_out_h(p), 0, lt_conv2d_out_w(p) };
}

/* Rows [from, from + rows) of the matrix, columns from (channel, tap) on: out[l][rows] */
static void pack_weight_panel(const weight_matrix *a, lt_real *out, int64_t from, int64_t rows,
                              int64_t k0, int64_t k)
{
    const lt_real *w = a->w + from * a->row + k0 / a->taps * a->channel;
    int64_t t = k0 % a->taps;

    for (int64_t l = 0; l < k; l++) {
        const lt_real *at = w + a->tap[t];

        for (int64_t r = 0; r < rows; r++)
            *out++ = at[r * a->row];
        if (++t == a->taps) {
            t = 0;
            w += a->channel;
        }
    }
}

static void pack_weights(const void *ctx, lt_real *out, const lt_tile *t, int64_t k0, int64_t k)
{
    const weight_matrix *a = &((const job *)ctx)->a;
    const int64_t panels = lt_ceil_div(t->m, lt_k->mr);

    if (a->whole) {
        lt_k->pack_a(out, a->w + t->m0 * a->row + k0 * a->column, a->row, a->column, t->m, k);
        return;
    }
    for (int64_t i = 0; i < panels; i++) {
        const int64_t from = i * t->m / panels, rows = (i + 1) * t->m / panels - from;

        pack_weight_panel(a, out + from * k, t->m0 + from, rows, k0, k);
    }
}

static void pack_positions(const void *ctx, lt_real *out, const lt_tile *t, int64_t image, int64_t k0,
                           int64_t k)
{
    const job *j = ctx;
    const int64_t plane = j->image.h * j->image.w;
    lt_conv_image at = j->image;

    at.x += image * j->image_step;
    if (j->plain)
        lt_k->pack_b(out, at.x + k0 * plane + t->n0, plane, 1, k, t->n);
    else
        lt_k->pack_image(out, &at, k0, k, t->n0, t->n);
    if (j->gate)
        lt_k->scale_panels(out, j->gate + image * j->p->c + k0, k, t->n);
}

/* Images share the packed weights, so several go into a task while that leaves enough of them. */
static int64_t images_at_once(const job *j)
{
    const int64_t tiles = j->tiles_m * j->tiles_n * j->p->groups;

    return lt_max_i64(1, lt_min_i64(j->p->n, lt_max_i64(256 / j->n, tiles * j->p->n / 32)));
}

/* At least some eight tasks. Large maps are cut first, as their tiles share no packed map; then rows, in
 * pairs of panels at least. */
static void cut(job *j)
{
    enum { TASKS = 8, ROWS = 28 };
    const int64_t many = j->n * j->p->n >= TASKS * 256, large = j->n >= 4 * j->m;
    int64_t wanted;

    j->tile_n = lt_tile_size(j->n, many || !large ? 256 : 128, 64);
    j->tiles_n = lt_ceil_div(j->n, j->tile_n);
    wanted = lt_ceil_div(TASKS, j->tiles_n * j->p->n);
    j->tile_m = lt_tile_size(j->m, lt_min_i64(LT_TILE_M, lt_max_i64(ROWS, lt_ceil_div(j->m, wanted))), 1);
    j->tiles_m = lt_ceil_div(j->m, j->tile_m);
    j->images = images_at_once(j);
}

static lt_tile tile_of(const job *j, int64_t tm, int64_t tn)
{
    const lt_tile t = {
        tm * j->tile_m, lt_min_i64(j->tile_m, j->m - tm * j->tile_m),
        tn * j->tile_n, lt_min_i64(j->tile_n, j->n - tn * j->tile_n),
    };
    return t;
}

static int64_t tasks_of(const job *j)
{
    return j->tiles_m * j->tiles_n * lt_ceil_div(j->p->n, j->images);
}

/* ---- forward -------------------------------------------------------------------------------------- */

static void run_tile(void *ctx, int64_t task)
{
    const job *j = ctx;
    const lt_tile t = tile_of(j, task % j->tiles_m, task / j->tiles_m % j->tiles_n);
    const int64_t from = task / j->tiles_m / j->tiles_n * j->images;
    lt_product p = j->product;

    p.c += t.m0 * p.ldc + t.n0;
    lt_product_tile(&p, &t, from, lt_min_i64(j->p->n, from + j->images));
}

/* The product of one group, without its data. */
static void forward_job(job *j, const lt_conv2d_params *p, const conv_taps *t)
{
    const int64_t cg = conv_group_c(p), out = lt_conv2d_out_h(p) * lt_conv2d_out_w(p);

    *j = (job){
        .p = p, .m = conv_group_o(p), .n = out, .plain = conv_pointwise(p), .image_step = p->c * p->h * p->w,
        .a = { NULL, cg * t->n, t->n, t->n, t->weight, true, 1 },
        .product = {
            .k = cg * t->n, .pack_a = pack_weights, .pack_b = pack_positions, .ctx = j,
            .ldc = out, .c_step = p->o * out,
        },
    };
    cut(j);
}

/* Where several tiles of rows read the same positions, all maps are packed once, before them: elements for
 * one image, or 0. */
static int64_t shared_maps(const job *j)
{
    const int64_t each = lt_product_packed_b(j->n, j->product.k);

    return j->tiles_m > 1 && each * j->p->n <= MOST_SHARED ? each : 0;
}

lt_conv_algorithm lt_conv2d_algorithm(const lt_conv2d_params *p)
{
    if (conv_group_c(p) == 1)
        return LT_CONV_DEPTHWISE;
    return lt_winograd_suits(p) ? LT_CONV_WINOGRAD : LT_CONV_DIRECT;
}

int64_t lt_conv2d_packed(const lt_conv2d_params *p)
{
    return lt_conv2d_algorithm(p) == LT_CONV_WINOGRAD ? lt_winograd_packed(p->o, p->c) : conv_weight_count(p);
}

static void pack_groups(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    const int64_t each = conv_weight_count(p) / p->groups;
    conv_taps t;
    job j;

    conv_window_taps(&t, p);
    forward_job(&j, p, &t);
    for (int64_t g = 0; g < p->groups; g++) {
        j.a.w = weights + g * each;
        lt_product_pack_a(&j.product, j.m, j.tile_m, packed + g * each);
    }
}

void lt_conv2d_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    if (conv_nothing(p))
        return;
    switch (lt_conv2d_algorithm(p)) {
    case LT_CONV_DEPTHWISE:
        memcpy(packed, weights, (size_t)conv_weight_count(p) * sizeof(lt_real));
        break;
    case LT_CONV_WINOGRAD:
        lt_winograd_pack(weights, p->c * 9, 9, false, p->o, p->c, packed);
        break;
    case LT_CONV_DIRECT:
        pack_groups(p, weights, packed);
        break;
    }
}

size_t lt_conv2d_forward_work(const lt_conv2d_params *p)
{
    conv_taps t;
    job j;

    if (conv_nothing(p) || lt_conv2d_algorithm(p) == LT_CONV_DEPTHWISE)
        return 0;
    if (lt_conv2d_algorithm(p) == LT_CONV_WINOGRAD)
        return lt_winograd_work(p, p->o, p->c);
    conv_window_taps(&t, p);
    forward_job(&j, p, &t);
    return (size_t)(shared_maps(&j) * p->n) * sizeof(lt_real);
}

static void forward_groups(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                           const lt_epilogue *e, const lt_real *gate, lt_real *y, lt_real *work)
{
    const int64_t cg = conv_group_c(p);
    conv_taps t;
    job j;

    conv_window_taps(&t, p);
    forward_job(&j, p, &t);
    j.gate = gate;
    for (int64_t g = 0; g < p->groups; g++) {
        lt_epilogue tail = *e;

        tail.row_bias = e->row_bias ? e->row_bias + g * j.m : NULL;
        tail.residual = e->residual ? e->residual + g * j.m * j.n : NULL;
        tail.ld_residual = j.n;
        j.image = conv_window_image(p, x + g * cg * p->h * p->w, &t);
        j.product.a = packed + g * j.m * j.product.k;
        j.product.c = y + g * j.m * j.n;
        j.product.e = &tail;
        j.product.b_step = shared_maps(&j);
        if (j.product.b_step) {
            lt_product_pack_b(&j.product, p->n, j.n, j.tile_n, work);
            j.product.b = work;
        }
        lt_parallel_for(tasks_of(&j), run_tile, &j);
    }
}

bool lt_conv2d_takes_gate(const lt_conv2d_params *p)
{
    return conv_pointwise(p) && p->groups == 1 && lt_conv2d_algorithm(p) == LT_CONV_DIRECT;
}

bool lt_conv2d_makes_mean(const lt_conv2d_params *p)
{
    return lt_conv2d_algorithm(p) == LT_CONV_DEPTHWISE;
}

void lt_conv2d_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                       const lt_conv2d_around *around, lt_real *y, void *work)
{
    const lt_epilogue e = { .row_bias = around->bias, .residual = around->residual, .act = around->act };

    assert(!around->gate || lt_conv2d_takes_gate(p));
    assert(!around->mean || lt_conv2d_makes_mean(p));
    if (conv_nothing(p))
        return;
    switch (lt_conv2d_algorithm(p)) {
    case LT_CONV_DEPTHWISE:
        lt_depthwise_forward(p, x, packed, &e, y, around->mean);
        break;
    case LT_CONV_WINOGRAD:
        lt_winograd_run(p, p->o, p->c, x, packed, &e, y, work);
        break;
    case LT_CONV_DIRECT:
        forward_groups(p, x, packed, &e, around->gate, y, work);
        break;
    }
}

/* ---- a part of one image ------------------------------------------------------------------------------ */

/* A direct convolution's part: its tiles come into scratch, and from there to their rows of the map. */
typedef struct {
    job j;
    lt_rect r;
    const lt_epilogue *e;
    lt_real *y;
} rect_job;

enum { RECT_N = 128 };              /* positions of a tile, whole rows of the part where they fit */

/* Row i of a tile, positions q of the part: bias, residual, activation, and to the map. */
static void place_row(const rect_job *d, const lt_tile *t, int64_t i, lt_real *row)
{
    const lt_conv2d_params *p = d->j.p;
    const int64_t W = lt_conv2d_out_w(p), cols = d->r.x1 - d->r.x0, o = t->m0 + i;

    for (int64_t q = 0; q < t->n;) {
        const int64_t y = (t->n0 + q) / cols, x = (t->n0 + q) % cols, n = lt_min_i64(t->n - q, cols - x);
        const int64_t at = (o * lt_conv2d_out_h(p) + d->r.y0 + y) * W + d->r.x0 + x;
        lt_epilogue e = *d->e;

        e.row_bias = e.row_bias ? e.row_bias + o : NULL;
        e.residual = e.residual ? e.residual + at : NULL;
        lt_k->epilogue(row + q, n, 1, n, &e);
        memcpy(d->y + at, row + q, (size_t)n * sizeof(lt_real));
        q += n;
    }
}

static void run_rect(void *ctx, int64_t task)
{
    const rect_job *d = ctx;
    const job *j = &d->j;
    const lt_tile t = tile_of(j, task % j->tiles_m, task / j->tiles_m);
    _Alignas(LT_ALIGN) lt_real tile[LT_TILE_M * RECT_N];
    lt_product product = j->product;

    product.c = tile;
    product.ldc = RECT_N;
    lt_product_tile(&product, &t, 0, 1);
    for (int64_t i = 0; i < t.m; i++)
        place_row(d, &t, i, tile + i * RECT_N);
}

/* Where the taps lie for the part's first position; all strides are 1. */
static void shift_taps(conv_taps *t, lt_rect r)
{
    for (int i = 0; i < t->n; i++) {
        t->at[i].dy += (int)r.y0;
        t->at[i].dx += (int)r.x0;
    }
}

static void forward_rect(const lt_conv2d_params *p, lt_rect r, const lt_real *x, const lt_real *packed,
                         const lt_epilogue *e, lt_real *y)
{
    const int64_t cols = r.x1 - r.x0;
    rect_job d = { .r = r, .e = e, .y = y };
    conv_taps t;

    conv_window_taps(&t, p);
    forward_job(&d.j, p, &t);                   /* cuts the rows as the packed weights are */
    shift_taps(&t, r);
    d.j.image = conv_window_image(p, x, &t);
    d.j.image.grid_w = cols;
    d.j.plain = false;
    d.j.n = (r.y1 - r.y0) * cols;
    d.j.tile_n = cols < RECT_N ? RECT_N / cols * cols : RECT_N;
    d.j.tiles_n = lt_ceil_div(d.j.n, d.j.tile_n);
    d.j.product.a = packed;
    d.j.product.ctx = &d.j;
    lt_parallel_for(d.j.tiles_m * d.j.tiles_n, run_rect, &d);
}

bool lt_conv2d_takes_rect(const lt_conv2d_params *p)
{
    return p->groups == 1 && p->stride_h == 1 && p->stride_w == 1
           && lt_conv2d_algorithm(p) != LT_CONV_DEPTHWISE;
}

size_t lt_conv2d_rect_work(const lt_conv2d_params *p)
{
    return lt_conv2d_algorithm(p) == LT_CONV_WINOGRAD ? lt_winograd_rect_work(p, p->o, p->c) : 0;
}

void lt_conv2d_forward_rect(const lt_conv2d_params *p, lt_rect r, const lt_real *x, const lt_real *packed,
                            const lt_real *bias, const lt_real *residual, lt_act act, lt_real *y, void *work)
{
    const lt_epilogue e = { .row_bias = bias, .residual = residual, .act = act };

    if (conv_nothing(p) || r.y0 >= r.y1 || r.x0 >= r.x1)
        return;
    if (lt_conv2d_algorithm(p) == LT_CONV_WINOGRAD)
        lt_winograd_run_rect(p, r, p->o, p->c, x, packed, &e, y, work);
    else
        forward_rect(p, r, x, packed, &e, y);
}

/* ---- gradient of x --------------------------------------------------------------------------------- */

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

typedef struct { job j; parity c; lt_real *dx; } data_job;

enum { SPREAD_M = 64, SPREAD_N = 128 };     /* a class's tile, on its way to its strided places */

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
    const job *j = &d->j;
    const lt_tile t = tile_of(j, task % j->tiles_m, task / j->tiles_m % j->tiles_n);
    const int64_t image = task / j->tiles_m / j->tiles_n;
    _Alignas(LT_ALIGN) lt_real tile[SPREAD_M * SPREAD_N];
    lt_product product = j->product;

    product.c = tile;
    product.ldc = SPREAD_N;
    product.c_step = 0;
    lt_product_tile(&product, &t, image, image + 1);
    spread(d, &t, image, tile);
}

static void cut_spread(job *j)
{
    j->images = 1;
    j->tile_m = lt_tile_size(j->m, SPREAD_M, 1);
    j->tile_n = lt_tile_size(j->n, SPREAD_N, 64);
    j->tiles_m = lt_ceil_div(j->m, j->tile_m);
    j->tiles_n = lt_ceil_div(j->n, j->tile_n);
}

static bool strided(const lt_conv2d_params *p)
{
    return p->stride_h > 1 || p->stride_w > 1;
}

/* The product of one class of one group, without its data. */
static void class_job(data_job *d, const lt_conv2d_params *p, parity c, const conv_taps *t)
{
    const int64_t cg = conv_group_c(p), og = conv_group_o(p), k_all = (int64_t)p->kh * p->kw;
    const int64_t out_h = lt_conv2d_out_h(p), out_w = lt_conv2d_out_w(p);

    *d = (data_job){
        .c = c,
        .j = {
            .p = p, .m = cg, .n = c.rows * c.cols, .plain = conv_pointwise(p),
            .image_step = p->o * out_h * out_w,
            .a = { NULL, k_all, cg * k_all, t->n, t->weight, k_all == 1, cg },
            .image = { NULL, out_h, out_w, c.cols, 1, 1, t->n, t->at },
            .product = {
                .k = og * t->n, .pack_a = pack_weights, .pack_b = pack_positions, .add = !strided(p),
                .ctx = &d->j, .ldc = p->h * p->w, .c_step = p->c * p->h * p->w,
            },
        },
    };
    if (strided(p))
        cut_spread(&d->j);
    else
        cut(&d->j);
}

typedef struct { const lt_real *dy, *weights; lt_real *dx, *work; } data_arrays;

/* work: the packed weights, and behind them the packed maps of dy where tiles share those */
static void run_class(data_job *d, const data_arrays *at)
{
    job *j = &d->j;
    const lt_conv2d_params *p = j->p;
    const int64_t cg = conv_group_c(p), og = conv_group_o(p), out = j->image.h * j->image.w;

    for (int64_t g = 0; g < p->groups; g++) {
        lt_real *packed_maps = at->work + conv_weight_count(p);

        d->dx = j->product.c = at->dx + g * cg * p->h * p->w;
        j->a.w = at->weights + g * og * cg * p->kh * p->kw;
        j->image.x = at->dy + g * og * out;
        j->product.a = NULL, j->product.b = NULL;
        lt_product_pack_a(&j->product, j->m, j->tile_m, at->work);
        j->product.b_step = shared_maps(j);
        if (j->product.b_step) {
            lt_product_pack_b(&j->product, p->n, j->n, j->tile_n, packed_maps);
            j->product.b = packed_maps;
        }
        j->product.a = at->work;
        lt_parallel_for(tasks_of(j), strided(p) ? run_spread : run_tile, strided(p) ? (void *)d : j);
    }
}

/* All classes, run with `at`, or with NULL measured: elements of the packed maps that the largest one shares. */
static int64_t each_class(const lt_conv2d_params *p, const data_arrays *at)
{
    int64_t shared = 0;
    conv_taps t;
    data_job d;

    for (int y0 = 0; y0 < p->stride_h && y0 < p->h; y0++)
        for (int x0 = 0; x0 < p->stride_w && x0 < p->w; x0++) {
            const parity c = { y0, x0, lt_ceil_div(p->h - y0, p->stride_h),
                               lt_ceil_div(p->w - x0, p->stride_w) };

            if (parity_taps(&t, p, c) == 0)
                continue;
            class_job(&d, p, c, &t);
            shared = lt_max_i64(shared, shared_maps(&d.j) * p->n);
            if (at)
                run_class(&d, at);
        }
    return shared;
}

/* With stride 1 and pad 1 a 3 x 3 window is its own transpose's: dy in the place of x. */
static void data_winograd(const lt_conv2d_params *p, const lt_real *dy, const lt_real *weights, lt_real *dx,
                          lt_real *work)
{
    const lt_epilogue add = { .residual = dx };
    lt_real *packed = work;

    lt_winograd_pack(weights, 9, p->c * 9, true, p->c, p->o, packed);
    lt_winograd_run(p, p->c, p->o, dy, packed, &add, dx, packed + lt_winograd_packed(p->c, p->o));
}

size_t lt_conv2d_backward_data_work(const lt_conv2d_params *p)
{
    if (conv_nothing(p) || lt_conv2d_algorithm(p) == LT_CONV_DEPTHWISE)
        return 0;
    if (lt_conv2d_algorithm(p) == LT_CONV_DIRECT)
        return (size_t)(conv_weight_count(p) + each_class(p, NULL)) * sizeof(lt_real);
    return (size_t)lt_winograd_packed(p->c, p->o) * sizeof(lt_real) + lt_winograd_work(p, p->c, p->o);
}

void lt_conv2d_backward_data(const lt_conv2d_params *p, const lt_real *dy, const lt_real *weights,
                             lt_real *dx, void *work)
{
    if (conv_nothing(p))
        return;
    switch (lt_conv2d_algorithm(p)) {
    case LT_CONV_DEPTHWISE:
        lt_depthwise_backward_data(p, dy, weights, dx);
        break;
    case LT_CONV_WINOGRAD:
        data_winograd(p, dy, weights, dx, work);
        break;
    case LT_CONV_DIRECT:
        each_class(p, &(data_arrays){ dy, weights, dx, work });
        break;
    }
}
