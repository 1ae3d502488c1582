/* SPDX-License-Identifier: Apache-2.0 */
/* The product that a convolution is: packing of both sides, cutting into tasks, and one task. */
#include "libtensor/kernels/conv_internal.h"

enum { MOST_SHARED = 6 << 20 };         /* elements of maps that are packed before all tiles */

/* Rows [from, from + rows) of the matrix, columns from (channel, tap) on: out[l][rows] */
static void pack_weight_panel(const conv_matrix *a, lt_real *out, int64_t from, int64_t rows,
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

void conv_pack_weights(const void *ctx, lt_real *out, const lt_tile *t, int64_t k0, int64_t k)
{
    const conv_matrix *a = &((const conv_job *)ctx)->a;
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

void conv_pack_positions(const void *ctx, lt_real *out, const lt_tile *t, int64_t image, int64_t k0, int64_t k)
{
    const conv_job *j = ctx;
    const int64_t plane = j->image.h * j->image.w;
    lt_conv_image at = j->image;

    at.x += image * j->image_step;
    if (j->plain)
        lt_k->pack_b(out, at.x + k0 * plane + t->n0, plane, 1, k, t->n);
    else
        lt_k->pack_image(out, &at, k0, k, t->n0, t->n);
    if (j->gate)
        lt_k->scale_panels(out, out, j->gate + image * j->p->c + k0, k, t->n);
}

/* Images share the packed weights, so several go into a task while that leaves enough of them. */
static int64_t images_at_once(const conv_job *j)
{
    const int64_t tiles = j->tiles_m * j->tiles_n * j->p->groups;

    return lt_max_i64(1, lt_min_i64(j->p->n, lt_max_i64(256 / j->n, tiles * j->p->n / 32)));
}

enum { TASKS = 8 };             /* at least some eight of them */

/* Where a product is little more than writing many large maps, tiles are so wide that each row of one is a run of
 * lines that the machine fetches ahead by itself. */
static int64_t most_columns(const conv_job *j)
{
    enum { SHALLOW = 64, WIDE = 1024, MIDDLE = 256, NARROW = 128 };
    const int64_t all = j->n * j->p->n;

    if (j->product.k <= SHALLOW && all >= 2 * TASKS * WIDE)
        return WIDE;
    return all >= TASKS * MIDDLE || j->n < 4 * j->m ? MIDDLE : NARROW;
}

/* Large maps are cut first, as their tiles share no packed map; then rows, in pairs of panels at least. */
void conv_job_cut(conv_job *j)
{
    enum { ROWS = 28 };
    int64_t wanted;

    j->tile_n = lt_tile_size(j->n, most_columns(j), 64);
    j->tiles_n = lt_ceil_div(j->n, j->tile_n);
    wanted = lt_ceil_div(TASKS, j->tiles_n * j->p->n);
    j->tile_m = lt_tile_size(j->m, lt_min_i64(LT_TILE_M, lt_max_i64(ROWS, lt_ceil_div(j->m, wanted))), 1);
    j->tiles_m = lt_ceil_div(j->m, j->tile_m);
    j->images = images_at_once(j);
}

lt_tile conv_job_tile(const conv_job *j, int64_t tm, int64_t tn)
{
    const lt_tile t = {
        tm * j->tile_m, lt_min_i64(j->tile_m, j->m - tm * j->tile_m),
        tn * j->tile_n, lt_min_i64(j->tile_n, j->n - tn * j->tile_n),
    };
    return t;
}

int64_t conv_job_tasks(const conv_job *j)
{
    return j->tiles_m * j->tiles_n * lt_ceil_div(j->p->n, j->images);
}

void conv_job_run(void *ctx, int64_t task)
{
    const conv_job *j = ctx;
    const lt_tile t = conv_job_tile(j, task % j->tiles_m, task / j->tiles_m % j->tiles_n);
    const int64_t from = task / j->tiles_m / j->tiles_n * j->images;
    lt_product p = j->product;

    p.c += t.m0 * p.ldc + t.n0;
    lt_product_tile(&p, &t, from, lt_min_i64(j->p->n, from + j->images));
}

int64_t conv_job_shared(const conv_job *j)
{
    const int64_t each = lt_product_packed_b(j->n, j->product.k);

    return j->tiles_m > 1 && each * j->p->n <= MOST_SHARED ? each : 0;
}
