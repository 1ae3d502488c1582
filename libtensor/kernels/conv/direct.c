/* SPDX-License-Identifier: Apache-2.0 */
/* A convolution as one product for each group, packed straight from the map: of all maps, or a part of one. */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/internal.h"
#include "libtensor/kernels/conv/way.h"

#include <string.h>

void conv_forward_job(conv_job *j, const lt_conv2d_params *p, conv_taps *t)
{
    const int64_t cg = conv_group_c(p), out = lt_conv2d_out_h(p) * lt_conv2d_out_w(p);

    conv_window_taps(t, p);
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

static int64_t packed_elements(const lt_conv2d_params *p, conv_direction d)
{
    (void)d;
    return conv_forward_on_tiles(p) ? lt_product_tiles_a(p->o, p->c * p->kh * p->kw) : conv_weight_count(p);
}

static void pack(const lt_conv2d_params *p, conv_direction d, const lt_real *weights, lt_real *packed)
{
    const int64_t each = conv_weight_count(p) / p->groups;
    conv_taps t;
    conv_job j;

    (void)d;
    conv_forward_job(&j, p, &t);
    for (int64_t g = 0; g < p->groups; g++) {
        j.a.w = weights + g * each;
        lt_product_pack_a(&j.product, j.m, j.tile_m, packed + g * each);
    }
}

static size_t work_bytes(const lt_conv2d_params *p, conv_direction d)
{
    conv_taps t;
    conv_job j;

    (void)d;
    conv_forward_job(&j, p, &t);
    return (size_t)(conv_job_shared(&j) * p->n) * sizeof(lt_real);
}

static void run(const lt_conv2d_params *p, conv_direction d, const lt_real *x, const lt_real *packed,
                const lt_conv2d_around *around, lt_real *y, void *work)
{
    const int64_t cg = conv_group_c(p);
    conv_taps t;
    conv_job j;

    (void)d;
    conv_forward_job(&j, p, &t);
    j.gate = around->gate;
    for (int64_t g = 0; g < p->groups; g++) {
        const lt_epilogue tail = {
            .row_bias = around->bias ? around->bias + g * j.m : NULL, .act = around->act,
            .residual = around->residual ? around->residual + g * j.m * j.n : NULL, .ld_residual = j.n,
        };

        j.image = conv_window_image(p, x + g * cg * p->h * p->w, &t);
        j.product.a = packed + g * j.m * j.product.k;
        j.product.c = y + g * j.m * j.n;
        j.product.e = &tail;
        j.product.b_step = conv_job_shared(&j);
        if (j.product.b_step) {
            lt_product_pack_b(&j.product, p->n, j.n, j.tile_n, work);
            j.product.b = work;
            j.product.b_columns = j.n;
        }
        lt_parallel_for(conv_job_tasks(&j), conv_job_run, &j);
    }
}

const conv_way conv_direct = { packed_elements, pack, work_bytes, run };

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

void conv_direct_rect(const lt_conv2d_params *p, lt_rect r, const lt_real *x, const lt_real *packed,
                      const lt_epilogue *e, lt_real *y)
{
    conv_taps t;
    conv_job j;

    conv_forward_job(&j, p, &t);
    j.product.a = packed;
    conv_run_rect(&j, &t, r, x, e, y);
}
