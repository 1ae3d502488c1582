/* SPDX-License-Identifier: Apache-2.0 */
/* The product that a convolution is: packing of both sides, cutting into tasks, and one task. */
#include "libtensor/kernels/conv/internal.h"

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

/* At most LT_TILES_SIDE terms; those in which rows follow each other are turned on their way. */
static void left_segment(const conv_matrix *a, lt_real *out, const lt_tile *t, int64_t k0, int64_t k)
{
    const lt_real *w = a->w + t->m0 * a->row + k0 * a->column;
    lt_real turned[LT_TILES_SIDE * LT_TILES_SIDE];

    if (a->whole && a->column == 1) {
        lt_k->tiles_left(out, w, LT_BLOCK, a->row, k, t->m, NULL);
    } else if (a->whole && a->row == 1) {
        lt_k->tiles_left_turned(out, w, a->column, k, t->m);
    } else {
        for (int64_t i = 0; i < t->m; i += LT_TILES_SIDE) {
            const int64_t rows = lt_min_i64(LT_TILES_SIDE, t->m - i);

            pack_weight_panel(a, turned, t->m0 + i, rows, k0, k);
            lt_k->tiles_left_turned(out + i * LT_TILES_ROW, turned, rows, k, rows);
        }
    }
}

void conv_left_weights(const void *ctx, lt_real *out, int64_t step, const lt_tile *t, int64_t k0, int64_t k)
{
    const conv_job *j = ctx;

    for (int64_t l = 0; l < k; l += LT_TILES_SIDE, out += step)
        left_segment(&j->a, out, t, k0 + l, lt_min_i64(LT_TILES_SIDE, k - l));
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

const lt_real *conv_right_positions(const void *ctx, lt_real *room, int64_t *ld, const lt_tile *t, int64_t image,
                                    int64_t k0, int64_t k)
{
    const conv_job *j = ctx;
    lt_conv_image at = j->image;

    at.x += image * j->image_step;
    if (j->plain && !j->gate) {
        *ld = at.h * at.w;
        return at.x + k0 * *ld + t->n0;
    }
    lt_k->image_rows(room, *ld, &at, t->n0, t->n, k0, k);
    for (int64_t l = 0; j->gate && l < k; l++)
        lt_k->scale(room + l * *ld, room + l * *ld, j->gate[image * j->p->c + k0 + l], (size_t)t->n);
    return room;
}

/* Images share the packed weights, so several go into a task while that leaves enough of them. */
static int64_t images_at_once(const conv_job *j)
{
    const int64_t tiles = j->tiles_m * j->tiles_n * j->p->groups;

    return lt_max_i64(1, lt_min_i64(j->p->n, lt_max_i64(256 / j->n, tiles * j->p->n / 32)));
}

enum { TASKS = 8, SHALLOW = 64 };       /* at least some eight of them; terms of a sum, which are soon read */

/* Where a product is little more than writing many large maps, tiles are so wide that each row of one is a run of
 * lines that the machine fetches ahead by itself. */
static int64_t most_columns(const conv_job *j)
{
    enum { WIDE = 1024, MIDDLE = 256, NARROW = 128 };
    const int64_t all = j->n * j->p->n;

    if (j->product.k <= SHALLOW && all >= 2 * TASKS * WIDE)
        return WIDE;
    return all >= TASKS * MIDDLE || j->n < 4 * j->m ? MIDDLE : NARROW;
}

bool conv_suits_tiles(const lt_conv2d_params *p, int64_t positions)
{
    enum { FEW = 64, LITTLE = 1 << 24 };        /* channels, positions; multiplications */
    const int64_t all = p->n * positions;

    return lt_k->gemm_tiles && p->groups == 1 && p->c >= FEW && p->o >= FEW && all >= FEW
           && all * p->c * p->o * p->kh * p->kw >= LITTLE;
}

bool conv_on_tiles(const lt_conv2d_params *p, int64_t m, int64_t n, int64_t k)
{
    return conv_suits_tiles(p, n) && (k > SHALLOW || m <= 2 * SHALLOW);
}

bool conv_forward_on_tiles(const lt_conv2d_params *p)
{
    return conv_on_tiles(p, p->o, lt_conv2d_out_h(p) * lt_conv2d_out_w(p), p->c * p->kh * p->kw);
}

int64_t conv_job_packed(const conv_job *j)
{
    return j->product.left ? lt_product_tiles_a(j->m, j->product.k) : j->m * j->product.k;
}

/* Large maps are cut first, as their tiles share no packed map; then rows, in pairs of panels at least. */
void conv_job_cut(conv_job *j, bool tiles)
{
    const int64_t unit = tiles ? LT_TILES_SIDE : 1, few = tiles ? 2 * LT_TILES_SIDE : 28;
    const int64_t most = tiles ? LT_PRODUCT_TILES_M : LT_TILE_M;
    int64_t wanted, rows;

    j->product.left = tiles ? conv_left_weights : NULL;
    j->product.right = tiles ? conv_right_positions : NULL;
    j->tile_n = lt_tile_size(j->n, tiles ? 2 * LT_PRODUCT_TILES_N : most_columns(j), tiles ? LT_TILES_SIDE : 64);
    j->tiles_n = lt_ceil_div(j->n, j->tile_n);
    wanted = lt_ceil_div(TASKS, j->tiles_n * j->p->n);
    rows = lt_ceil_div(lt_max_i64(few, lt_ceil_div(j->m, wanted)), unit) * unit;
    j->tile_m = lt_tile_size(j->m, lt_min_i64(most, rows), unit);
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
    const int64_t k = j->product.k, each = j->product.left ? lt_product_tiles_b(j->n, k) : lt_product_packed_b(j->n, k);

    return j->tiles_m > 1 && each * j->p->n <= CONV_MOST_SHARED ? each : 0;
}
