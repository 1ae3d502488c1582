/* SPDX-License-Identifier: Apache-2.0 */
/* The algorithm of a convolution, its packed weights, and its forward pass: of whole maps, or a part of one. */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv_internal.h"
#include "libtensor/kernels/conv_tapwise.h"
#include "libtensor/kernels/conv_turned.h"
#include "libtensor/kernels/depthwise.h"
#include "libtensor/kernels/winograd.h"
#include "libtensor/kernels/winograd2.h"

#include <assert.h>
#include <string.h>

/* Of n cells and their padding; 0 where the window does not fit */
static int64_t out_size(int64_t n, int pad, int window, int dilation, int stride)
{
    const int64_t free = n + 2 * (int64_t)pad - (int64_t)dilation * (window - 1) - 1;

    return free < 0 ? 0 : free / stride + 1;
}

int64_t lt_conv2d_out_h(const lt_conv2d_params *p)
{
    return out_size(p->h, p->pad_h, p->kh, p->dil_h, p->stride_h);
}

int64_t lt_conv2d_out_w(const lt_conv2d_params *p)
{
    return out_size(p->w, p->pad_w, p->kw, p->dil_w, p->stride_w);
}

lt_rect lt_conv2d_all(const lt_conv2d_params *p)
{
    return (lt_rect){ 0, lt_conv2d_out_h(p), 0, lt_conv2d_out_w(p) };
}

/* ---- forward -------------------------------------------------------------------------------------- */

void conv_forward_job(conv_job *j, const lt_conv2d_params *p, const conv_taps *t)
{
    const int64_t cg = conv_group_c(p), out = lt_conv2d_out_h(p) * lt_conv2d_out_w(p);

    *j = (conv_job){
        .p = p, .m = conv_group_o(p), .n = out, .plain = conv_pointwise(p), .image_step = p->c * p->h * p->w,
        .a = { NULL, cg * t->n, t->n, t->n, t->weight, true, 1 },
        .product = {
            .k = cg * t->n, .pack_a = conv_pack_weights, .pack_b = conv_pack_positions, .ctx = j,
            .ldc = out, .c_step = p->o * out,
        },
    };
    conv_job_cut(j, conv_on_tiles(p, j->m, j->n, j->product.k));
}

lt_conv_algorithm lt_conv2d_algorithm(const lt_conv2d_params *p)
{
    enum { MANY = 8 };          /* outputs of one map: worth packing its windows */

    if (conv_group_c(p) == 1 && conv_group_o(p) < MANY)
        return LT_CONV_DEPTHWISE;
    if (lt_few_suits(p))
        return LT_CONV_FEW;
    if (lt_winograd2_suits(p))
        return LT_CONV_WINOGRAD2;
    if (lt_winograd_suits(p))
        return LT_CONV_WINOGRAD;
    if (lt_tapwise_suits(p, LT_TAPWISE_FORWARD))
        return LT_CONV_TAPWISE;
    if (conv_on_tiles(p, p->o, lt_conv2d_out_h(p) * lt_conv2d_out_w(p), p->c * p->kh * p->kw))
        return LT_CONV_TILES;
    return lt_turned_suits(p) ? LT_CONV_TURNED : LT_CONV_DIRECT;
}

int64_t lt_conv2d_packed(const lt_conv2d_params *p)
{
    switch (lt_conv2d_algorithm(p)) {
    case LT_CONV_TURNED:
        return lt_turned_packed(p);
    case LT_CONV_TAPWISE:
        return lt_tapwise_packed(p, LT_TAPWISE_FORWARD);
    case LT_CONV_WINOGRAD:
        return lt_winograd_packed(p->o, p->c);
    case LT_CONV_WINOGRAD2:
        return lt_winograd2_packed(p->o, p->c);
    case LT_CONV_TILES:
        return lt_product_tiles_a(p->o, p->c * p->kh * p->kw);
    default:
        return conv_weight_count(p);
    }
}

static void pack_groups(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    const int64_t each = conv_weight_count(p) / p->groups;
    conv_taps t;
    conv_job j;

    conv_window_taps(&t, p);
    conv_forward_job(&j, p, &t);
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
    case LT_CONV_FEW:
        memcpy(packed, weights, (size_t)conv_weight_count(p) * sizeof(lt_real));
        break;
    case LT_CONV_TURNED:
        lt_turned_pack(p, weights, packed);
        break;
    case LT_CONV_TAPWISE:
        lt_tapwise_pack(p, LT_TAPWISE_FORWARD, weights, packed);
        break;
    case LT_CONV_WINOGRAD:
        lt_winograd_pack(weights, p->c * 9, 9, false, p->o, p->c, packed);
        break;
    case LT_CONV_WINOGRAD2:
        lt_winograd2_pack(weights, p->c * 9, 9, false, p->o, p->c, packed);
        break;
    case LT_CONV_TILES:
    case LT_CONV_DIRECT:
        pack_groups(p, weights, packed);
        break;
    }
}

size_t lt_conv2d_forward_work(const lt_conv2d_params *p)
{
    conv_taps t;
    conv_job j;

    if (conv_nothing(p))
        return 0;
    switch (lt_conv2d_algorithm(p)) {
    case LT_CONV_DEPTHWISE:
    case LT_CONV_FEW:
        return 0;
    case LT_CONV_TURNED:
        return lt_turned_work(p);
    case LT_CONV_TAPWISE:
        return lt_tapwise_work(p, LT_TAPWISE_FORWARD);
    case LT_CONV_WINOGRAD:
        return lt_winograd_work(p, p->o, p->c);
    case LT_CONV_WINOGRAD2:
        return lt_winograd2_work(p, p->o, p->c);
    case LT_CONV_TILES:
    case LT_CONV_DIRECT:
        break;
    }
    conv_window_taps(&t, p);
    conv_forward_job(&j, p, &t);
    return (size_t)(conv_job_shared(&j) * p->n) * sizeof(lt_real);
}

static void forward_groups(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                           const lt_epilogue *e, const lt_real *gate, lt_real *y, lt_real *work)
{
    const int64_t cg = conv_group_c(p);
    conv_taps t;
    conv_job j;

    conv_window_taps(&t, p);
    conv_forward_job(&j, p, &t);
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
        j.product.b_step = conv_job_shared(&j);
        if (j.product.b_step) {
            lt_product_pack_b(&j.product, p->n, j.n, j.tile_n, work);
            j.product.b = work;
        }
        lt_parallel_for(conv_job_tasks(&j), conv_job_run, &j);
    }
}

bool lt_conv2d_takes_gate(const lt_conv2d_params *p)
{
    return conv_pointwise(p) && p->groups == 1 && lt_conv2d_algorithm(p) != LT_CONV_DEPTHWISE;
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
    case LT_CONV_FEW:
        lt_depthwise_forward(p, x, packed, &e, y, around->mean);
        break;
    case LT_CONV_TURNED:
        lt_turned_forward(p, x, packed, around, y, work);
        break;
    case LT_CONV_TAPWISE:
        lt_tapwise_run(p, LT_TAPWISE_FORWARD, x, packed, around, false, y, work);
        break;
    case LT_CONV_WINOGRAD:
        lt_winograd_run(p, p->o, p->c, x, packed, &e, y, work);
        break;
    case LT_CONV_WINOGRAD2:
        lt_winograd2_run(p, p->o, p->c, x, packed, around, y, work);
        break;
    case LT_CONV_TILES:
    case LT_CONV_DIRECT:
        forward_groups(p, x, packed, &e, around->gate, y, work);
        break;
    }
}

/* ---- a part of one image ------------------------------------------------------------------------------ */

/* A direct convolution's part: its tiles come into scratch, and from there to their rows of the map. */
typedef struct {
    const conv_job *j;
    lt_rect r;
    const lt_epilogue *e;
    lt_real *y;
} rect_job;

enum { RECT_N = 128 };              /* positions of a tile, whole rows of the part where they fit */

/* Row i of a tile, positions q of the part: bias, residual, activation, and to the map. */
static void place_row(const rect_job *d, const lt_tile *t, int64_t i, lt_real *row)
{
    const lt_conv2d_params *p = d->j->p;
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
    const conv_job *j = d->j;
    const lt_tile t = conv_job_tile(j, task % j->tiles_m, task / j->tiles_m);
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

/* The rows are cut as the packed weights are. */
void conv_run_rect(conv_job *j, conv_taps *t, lt_rect r, const lt_real *x, const lt_epilogue *e, lt_real *y)
{
    const int64_t cols = r.x1 - r.x0;
    rect_job d = { j, r, e, y };

    shift_taps(t, r);
    j->image = conv_window_image(j->p, x, t);
    j->image.grid_w = cols;
    j->plain = false;
    j->n = (r.y1 - r.y0) * cols;
    j->tile_n = cols < RECT_N ? RECT_N / cols * cols : RECT_N;
    j->tiles_n = lt_ceil_div(j->n, j->tile_n);
    lt_parallel_for(j->tiles_m * j->tiles_n, run_rect, &d);
}

static void forward_rect(const lt_conv2d_params *p, lt_rect r, const lt_real *x, const lt_real *packed,
                         const lt_epilogue *e, lt_real *y)
{
    conv_taps t;
    conv_job j;

    conv_window_taps(&t, p);
    conv_forward_job(&j, p, &t);
    j.product.a = packed;
    conv_run_rect(&j, &t, r, x, e, y);
}

bool lt_conv2d_takes_rect(const lt_conv2d_params *p)
{
    const lt_conv_algorithm a = lt_conv2d_algorithm(p);
    const bool known = a == LT_CONV_DIRECT || a == LT_CONV_TILES || a == LT_CONV_WINOGRAD;

    return p->groups == 1 && p->stride_h == 1 && p->stride_w == 1 && known;
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
