/* SPDX-License-Identifier: Apache-2.0 */
/* The gradient of a convolution's weights as a product of dy and of what the taps read of x. */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/weights.h"

#include <string.h>

/* The part of one image's positions that comes next: a block of the product may go over several images. */
typedef struct { int64_t image, at, n; } stretch;

static stretch stretch_at(const weights_piece *w, int64_t k, int64_t most)
{
    const int64_t at = k % w->j->positions;

    return (stretch){ w->from + k / w->j->positions, at, lt_min_i64(most, w->j->positions - at) };
}

static void pack_dy(const void *ctx, lt_real *out, const lt_tile *t, int64_t k0, int64_t k)
{
    const weights_piece *w = ctx;
    const int64_t panels = lt_ceil_div(t->m, lt_k->mr), plane = w->j->positions;

    for (int64_t i = 0; i < panels; i++) {
        const int64_t from = i * t->m / panels, rows = (i + 1) * t->m / panels - from;

        for (int64_t done = 0; done < k;) {
            const stretch s = stretch_at(w, k0 + done, k - done);

            lt_k->pack_a(out + from * k + done * rows, weights_dy(w, s.image) + (t->m0 + from) * plane + s.at, plane, 1,
                         rows, s.n);
            done += s.n;
        }
    }
}

/* The maps whose rows a product has on the left, or on the right, of one image, from map `first` on */
static const lt_real *left_of(const weights_piece *w, int64_t image, int64_t first)
{
    return (w->j->swapped ? weights_x : weights_dy)(w, image) + first * w->j->positions;
}

static const lt_real *right_of(const weights_piece *w, int64_t image, int64_t first)
{
    return (w->j->swapped ? weights_dy : weights_x)(w, image) + first * w->j->positions;
}

/* Rows of tiles: positions of maps, eight maps at a time, so that a page is met once */
static void left_maps(const weights_piece *w, lt_real *out, const lt_real *map, int64_t step, int64_t maps, int64_t k)
{
    enum { AT_ONCE = 8 };
    const int64_t plane = w->j->positions;

    for (int64_t i = 0; i < maps; i += AT_ONCE)
        for (int64_t l = 0; l < k; l += LT_TILES_SIDE)
            lt_k->tiles_left(out + i * LT_TILES_ROW + l / LT_TILES_SIDE * step, map + i * plane + l, LT_BLOCK, plane,
                             lt_min_i64(LT_TILES_SIDE, k - l), lt_min_i64(AT_ONCE, maps - i), NULL);
}

/* A segment of positions of several images, put together */
static void left_segment(const weights_piece *w, lt_real *out, const lt_tile *t, int64_t k0, int64_t k)
{
    lt_real room[LT_PRODUCT_TILES_M * LT_TILES_SIDE];

    for (int64_t done = 0; done < k;) {
        const stretch s = stretch_at(w, k0 + done, k - done);
        const lt_real *map = left_of(w, s.image, t->m0) + s.at;

        for (int64_t i = 0; i < t->m; i++)
            memcpy(room + i * LT_TILES_SIDE + done, map + i * w->j->positions, (size_t)s.n * sizeof(*room));
        done += s.n;
    }
    lt_k->tiles_left(out, room, LT_BLOCK, LT_TILES_SIDE, k, t->m, NULL);
}

static void pack_left(const void *ctx, lt_real *out, int64_t step, const lt_tile *t, int64_t k0, int64_t k)
{
    const weights_piece *w = ctx;

    for (int64_t done = 0, n; done < k; done += n, out += lt_ceil_div(n, LT_TILES_SIDE) * step) {
        const stretch s = stretch_at(w, k0 + done, k - done);

        n = s.n < k - done ? s.n / LT_TILES_SIDE * LT_TILES_SIDE : s.n;
        if (n) {
            left_maps(w, out, left_of(w, s.image, t->m0) + s.at, step, t->m, n);
        } else {
            n = lt_min_i64(LT_TILES_SIDE, k - done);
            left_segment(w, out, t, k0 + done, n);
        }
    }
}

static void pack_x_panel(const weights_piece *w, lt_real *out, const stretch *s, int64_t n0, int64_t n)
{
    const weights_job *j = w->j;
    const lt_real *x = weights_x(w, s->image);

    if (conv_pointwise(&j->p)) {
        lt_k->pack_b(out, x + n0 * j->positions + s->at, 1, j->positions, s->n, n);
    } else {
        const lt_conv_image g = conv_window_image(&j->p, x, &j->taps);

        lt_k->pack_image_t(out, &g, s->at, s->n, n0, n);
    }
}

static void pack_x(const void *ctx, lt_real *out, const lt_tile *t, int64_t image, int64_t k0, int64_t k)
{
    const weights_piece *w = ctx;
    const int nr = lt_k->nr;

    (void)image;
    for (int64_t i = 0; i < t->n; i += nr)
        for (int64_t done = 0; done < k;) {
            const stretch s = stretch_at(w, k0 + done, k - done);

            pack_x_panel(w, out + i * k + done * nr, &s, t->n0 + i, lt_min_i64(nr, t->n - i));
            done += s.n;
        }
}

/* Columns n0 to n0 + n of x, turned: positions are rows. */
static void turn_windows(const weights_piece *w, lt_real *out, int64_t ld, const stretch *s, int64_t n0, int64_t n)
{
    enum { AT_ONCE = 32, LD = LT_PACK_K + LT_WEIGHTS_SLACK };
    const lt_conv_image g = conv_window_image(&w->j->p, weights_x(w, s->image), &w->j->taps);
    lt_real lines[AT_ONCE * LD];

    for (int64_t i = 0; i < n; i += AT_ONCE) {
        const int64_t count = lt_min_i64(AT_ONCE, n - i);

        lt_k->image_rows(lines, LD, &g, s->at, s->n, n0 + i, count);
        lt_k->turn(out + i, ld, lines, LD, count, s->n, false);
    }
}

static const lt_real *pack_right(const void *ctx, lt_real *room, int64_t *ld, const lt_tile *t, int64_t image,
                                 int64_t k0, int64_t k)
{
    const weights_piece *w = ctx;

    (void)image;
    for (int64_t done = 0; done < k;) {
        const stretch s = stretch_at(w, k0 + done, k - done);

        if (w->j->swapped || conv_pointwise(&w->j->p))
            lt_k->turn(room + done * *ld, *ld, right_of(w, s.image, t->n0) + s.at, w->j->positions, t->n, s.n, false);
        else
            turn_windows(w, room + done * *ld, *ld, &s, t->n0, t->n);
        done += s.n;
    }
    return room;
}

/* One chunk has dw for the beginning of its chains; several have a place each. */
static void run_product(void *ctx, int64_t task)
{
    const weights_job *j = ctx;
    const weights_piece w = weights_piece_of(j, task);
    const bool alone = j->chunks == 1 && !j->swapped;
    lt_real *sums = alone ? j->dw : j->part + w.chunk * conv_weight_count(&j->p);
    const lt_product product = {
        .k = (w.to - w.from) * j->positions, .ctx = &w, .pack_a = pack_dy, .pack_b = pack_x,
        .left = j->tiles ? pack_left : NULL, .right = pack_right,
        .c = sums + (w.group * conv_group_o(&j->p) + w.t.m0) * j->n + w.t.n0, .ldc = j->n, .add = alone && j->add,
    };

    lt_product_tile(&product, &w.t, 0, 1);
}

enum { RUN = 4096 };

static void add_run(void *ctx, int64_t task)
{
    const weights_job *j = ctx;
    const int64_t n = conv_weight_count(&j->p), at = task * RUN;
    const size_t run = (size_t)lt_min_i64(RUN, n - at);

    if (!j->add)
        memset(j->dw + at, 0, run * sizeof(*j->dw));
    for (int64_t i = 0; i < j->chunks; i++)
        lt_k->add_to(j->dw + at, j->part + i * n + at, run);
}

void conv_weights_add_chunks(weights_job *j)
{
    lt_parallel_for(lt_ceil_div(conv_weight_count(&j->p), RUN), add_run, j);
}

/* Rows of the sums, which are columns of dw */
static void turn_strip(void *ctx, int64_t strip)
{
    const weights_job *j = ctx;
    const int64_t at = strip * LT_TILES_SIDE;

    for (int64_t i = 0; i < j->chunks; i++)
        lt_k->turn(j->dw + at, j->m, j->part + (i * j->m + at) * j->n, j->n, lt_min_i64(LT_TILES_SIDE, j->m - at), j->n,
                   j->add || i > 0);
}

void conv_weights_by_product(weights_job *j)
{
    lt_parallel_for(j->pieces * j->chunks, run_product, j);
    if (j->swapped)
        lt_parallel_for(lt_ceil_div(j->m, LT_TILES_SIDE), turn_strip, j);
    else if (j->chunks > 1)
        conv_weights_add_chunks(j);
}

