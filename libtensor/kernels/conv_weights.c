/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gradients of a convolution's weights and bias: dw[o][(c, tap)] = the sum over images and positions of
 * dy[o] and of what (c, tap) reads of x.
 */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv_internal.h"
#include "libtensor/kernels/depthwise.h"
#include "libtensor/kernels/product.h"
#include "libtensor/kernels/winograd_weights.h"

#include <string.h>

enum {
    MOST_CHUNKS = 8,                    /* of a batch, each summed on its own ... */
    FEW_TASKS = 16,                     /* ... where its tiles alone are fewer than this */
    WINDOW_CHANNELS = 64,               /* of x in a task that goes by windows, */
    WINDOW_LANES = 128,                 /* and of dy, */
    WINDOW_SLACK = 16,                  /* and what image_rows may write after each channel */
};

typedef enum {
    BY_WINDOW,                          /* 3 x 3 to 7 x 7: a copy of x with its zeros serves all taps */
    BY_SAMPLES,                         /* 1 x 1 with a stride: BY_PRODUCT, after a copy of what it reads */
    BY_PRODUCT,                         /* both factors packed */
} weights_way;

/* What the window goes over at once: a band of output rows, of several images when they are small. */
typedef struct { int64_t rows, images, line, lines, channel; } window_band;

typedef struct {
    lt_conv2d_params p;
    const lt_real *x, *dy;
    lt_real *dw, *part;                 /* part: what a chunk's tasks sum, where there are several */
    conv_taps taps;
    int64_t positions;                  /* of an output map */
    weights_way way;
    bool tiles, swapped;                /* on AMX's tiles; x on the left and dy on the right */
    window_band band;
    int64_t m, n, tile_m, tile_n, tiles_m, tiles_n, pieces, chunks;
} weights_job;

/* ---- cutting ------------------------------------------------------------------------------------------- */

static int64_t span(int64_t n, int step, int size)
{
    return (n - 1) * step + size;
}

static void set_band(window_band *b, const lt_conv2d_params *p, int64_t rows, int64_t images)
{
    b->rows = rows;
    b->images = images;
    b->line = span(lt_conv2d_out_w(p), p->stride_w, p->kw);
    b->lines = span(rows, p->stride_h, p->kh);
    b->channel = images * b->lines * b->line + WINDOW_SLACK;
}

static bool fits(const window_band *b)
{
    return b->channel * WINDOW_CHANNELS <= LT_SCRATCH_A;
}

static bool windows_suit(const lt_conv2d_params *p)
{
    return (p->kh == 3 || p->kh == 5 || p->kh == 7) && p->kw == p->kh && p->dil_h == 1 && p->dil_w == 1
           && p->stride_h == p->stride_w;
}

/* The largest band that fits the scratch; no rows where none does. */
static window_band band_of(const lt_conv2d_params *p)
{
    const int64_t h = lt_conv2d_out_h(p), w = lt_conv2d_out_w(p);
    int64_t rows = windows_suit(p) ? lt_min_i64(h, LT_PACK_K / w) : 0, images;
    window_band b = { 0 };

    while (rows > 0 && (set_band(&b, p, rows, 1), !fits(&b)))
        rows--;
    if (rows < 1)
        return (window_band){ 0 };
    rows = lt_ceil_div(h, lt_ceil_div(h, rows));
    images = rows < h ? 1 : lt_min_i64(p->n, LT_PACK_K / (h * w));
    while (set_band(&b, p, rows, images), !fits(&b))
        images--;
    return b;
}

static bool strided_samples(const lt_conv2d_params *p)
{
    return p->kh == 1 && p->kw == 1 && !conv_pointwise(p);
}

static void set_sizes(weights_job *j)
{
    const lt_conv2d_params *p = &j->p;
    const int64_t cg = conv_group_c(p), og = conv_group_o(p), unit = (int64_t)p->kh * p->kw;

    j->m = cg * unit, j->n = og;
    if (j->tiles) {
        j->swapped = unit == 1 && cg > og;
        j->m = j->swapped ? cg : og, j->n = j->swapped ? og : cg * unit;
        j->tile_m = lt_tile_size(j->m, LT_PRODUCT_TILES_M, LT_TILES_SIDE);
        j->tile_n = lt_tile_size(j->n, LT_PRODUCT_TILES_N, LT_TILES_SIDE);
    } else if (j->way == BY_WINDOW) {
        j->tile_m = lt_tile_size(cg, WINDOW_CHANNELS, 1) * unit;
        j->tile_n = lt_tile_size(j->n, WINDOW_LANES, 64);
    } else {
        j->m = og, j->n = cg * unit;
        j->tile_m = lt_tile_size(j->m, LT_TILE_M, 1);
        j->tile_n = lt_tile_size(j->n, 256, 64);
    }
}

static void cut(weights_job *j)
{
    enum { MANY = 128 };                /* channels of x, for which windows are worth turning */
    const lt_conv2d_params *p = &j->p;

    conv_window_taps(&j->taps, p);
    j->positions = lt_conv2d_out_h(p) * lt_conv2d_out_w(p);
    j->tiles = (j->taps.n == 1 || p->c >= MANY) && conv_suits_tiles(p, j->positions);
    j->band = j->tiles ? (window_band){ 0 } : band_of(p);
    j->way = j->band.rows ? BY_WINDOW : strided_samples(p) ? BY_SAMPLES : BY_PRODUCT;
    set_sizes(j);
    j->tiles_m = lt_ceil_div(j->m, j->tile_m);
    j->tiles_n = lt_ceil_div(j->n, j->tile_n);
    j->pieces = j->tiles_m * j->tiles_n * p->groups;
    j->chunks = lt_min_i64(lt_ceil_div(FEW_TASKS, j->pieces), lt_min_i64(MOST_CHUNKS, p->n));
}

/* A task: one tile of one group's sums, over some of the images. */
typedef struct {
    const weights_job *j;
    lt_tile t;
    int64_t task, group, chunk, from, to;
} piece;

static piece piece_of(const weights_job *j, int64_t task)
{
    const int64_t chunk = task % j->chunks, tile = task / j->chunks;
    const int64_t m0 = tile % j->tiles_m * j->tile_m, n0 = tile / j->tiles_m % j->tiles_n * j->tile_n;

    return (piece){
        j, { m0, lt_min_i64(j->tile_m, j->m - m0), n0, lt_min_i64(j->tile_n, j->n - n0) },
        task, tile / j->tiles_m / j->tiles_n, chunk, chunk * j->p.n / j->chunks, (chunk + 1) * j->p.n / j->chunks,
    };
}

static const lt_real *x_of(const piece *w, int64_t image)
{
    const lt_conv2d_params *p = &w->j->p;

    return w->j->x + (image * p->c + w->group * conv_group_c(p)) * p->h * p->w;
}

static const lt_real *dy_of(const piece *w, int64_t image)
{
    const lt_conv2d_params *p = &w->j->p;

    return w->j->dy + (image * p->o + w->group * conv_group_o(p)) * w->j->positions;
}

/* ---- by windows ---------------------------------------------------------------------------------------- */

static lt_real *window_tile(const piece *w)
{
    return w->j->part + w->task * w->j->tile_m * w->j->tile_n;          /* (tile_m, tile_n) */
}

/* The lines of x under a band of output rows from `row` on, with their zeros. */
static void copy_lines(const piece *w, lt_real *out, int64_t image, int64_t channel, int64_t channels, int64_t row,
                       int64_t rows)
{
    const lt_conv2d_params *p = &w->j->p;
    const int64_t line = w->j->band.line;
    const lt_tap corner = { (int)(row * p->stride_h) - p->pad_h, -p->pad_w };
    const lt_conv_image g = { x_of(w, image), p->h, p->w, line, 1, 1, 1, &corner };

    lt_k->image_rows(out, w->j->band.channel, &g, 0, span(rows, p->stride_h, p->kh) * line, channel, channels);
}

/* out[panel][row + position][lane], `rows` rows in all: n positions of the tile's channels of dy, turned. */
static void turn_lanes(const piece *w, lt_real *out, const lt_real *dy, int64_t rows, int64_t row, int64_t n)
{
    const int nr = lt_k->nr;

    for (int64_t o = 0; o < w->t.n; o += nr)
        lt_k->pack_b(out + o * rows + row * nr, dy + o * w->j->positions, 1, w->j->positions, n,
                     lt_min_i64(nr, w->t.n - o));
}

/* The windows at `rows` rows from `row` on of `images` images: x goes to a, dy to b. */
static void band_sums(const piece *w, lt_real *a, lt_real *b, int64_t image, int64_t images, int64_t row,
                      int64_t rows)
{
    const weights_job *j = w->j;
    const int64_t cols = lt_conv2d_out_w(&j->p), n = rows * cols, each = j->band.lines * j->band.line;
    const int64_t taps = j->taps.n, channel = w->t.m0 / taps, channels = w->t.m / taps;
    lt_window g = { a, each, j->band.line, images, rows, cols, j->p.stride_h, j->p.kh };

    for (int64_t i = 0; i < images; i++) {
        copy_lines(w, a + i * each, image + i, channel, channels, row, rows);
        turn_lanes(w, b, dy_of(w, image + i) + w->t.n0 * j->positions + row * cols, images * n, i * n, n);
    }
    for (int64_t o = 0; o < w->t.n; o += lt_k->nr)
        for (int64_t c = 0; c < channels; c++) {
            g.x = a + c * j->band.channel;
            lt_k->window_sums(window_tile(w) + c * taps * j->tile_n + o, j->tile_n, &g, b + o * images * n,
                              lt_min_i64(lt_k->nr, w->t.n - o), image > w->from || row > 0);
        }
}

static void add_window_tile(const piece *w)
{
    const weights_job *j = w->j;
    const int64_t k = conv_group_c(&j->p) * j->taps.n, o = w->group * conv_group_o(&j->p) + w->t.n0;

    lt_k->turn(j->dw + o * k + w->t.m0, k, window_tile(w), j->tile_n, w->t.m, w->t.n, true);
}

static void window_task(void *ctx, lt_real *a, lt_real *b)
{
    const piece *w = ctx;
    const window_band *band = &w->j->band;
    const int64_t h = lt_conv2d_out_h(&w->j->p);

    for (int64_t image = w->from; image < w->to; image += band->images)
        for (int64_t row = 0; row < h; row += band->rows)
            band_sums(w, a, b, image, lt_min_i64(band->images, w->to - image), row, lt_min_i64(band->rows, h - row));
    if (w->j->chunks == 1)
        add_window_tile(w);
}

static void run_window(void *ctx, int64_t task)
{
    piece w = piece_of(ctx, task);

    lt_with_scratch(window_task, &w);
}

static void add_window_chunks(void *ctx, int64_t tile)
{
    const weights_job *j = ctx;

    for (int64_t i = 0; i < j->chunks; i++) {
        const piece w = piece_of(j, tile * j->chunks + i);

        add_window_tile(&w);
    }
}

static void by_windows(weights_job *j)
{
    lt_parallel_for(j->pieces * j->chunks, run_window, j);
    if (j->chunks > 1)
        lt_parallel_for(j->pieces, add_window_chunks, j);
}

/* ---- as a product -------------------------------------------------------------------------------------- */

/* The part of one image's positions that comes next: a block of the product may go over several images. */
typedef struct { int64_t image, at, n; } stretch;

static stretch stretch_at(const piece *w, int64_t k, int64_t most)
{
    const int64_t at = k % w->j->positions;

    return (stretch){ w->from + k / w->j->positions, at, lt_min_i64(most, w->j->positions - at) };
}

static void pack_dy(const void *ctx, lt_real *out, const lt_tile *t, int64_t k0, int64_t k)
{
    const piece *w = ctx;
    const int64_t panels = lt_ceil_div(t->m, lt_k->mr), plane = w->j->positions;

    for (int64_t i = 0; i < panels; i++) {
        const int64_t from = i * t->m / panels, rows = (i + 1) * t->m / panels - from;

        for (int64_t done = 0; done < k;) {
            const stretch s = stretch_at(w, k0 + done, k - done);

            lt_k->pack_a(out + from * k + done * rows, dy_of(w, s.image) + (t->m0 + from) * plane + s.at, plane, 1,
                         rows, s.n);
            done += s.n;
        }
    }
}

/* The maps whose rows a product has on the left, or on the right, of one image, from map `first` on */
static const lt_real *left_of(const piece *w, int64_t image, int64_t first)
{
    return (w->j->swapped ? x_of : dy_of)(w, image) + first * w->j->positions;
}

static const lt_real *right_of(const piece *w, int64_t image, int64_t first)
{
    return (w->j->swapped ? dy_of : x_of)(w, image) + first * w->j->positions;
}

/* Rows of tiles: positions of maps, eight maps at a time, so that a page is met once */
static void left_maps(const piece *w, lt_real *out, const lt_real *map, int64_t step, int64_t maps, int64_t k)
{
    enum { AT_ONCE = 8 };
    const int64_t plane = w->j->positions;

    for (int64_t i = 0; i < maps; i += AT_ONCE)
        for (int64_t l = 0; l < k; l += LT_TILES_SIDE)
            lt_k->tiles_left(out + i * LT_TILES_ROW + l / LT_TILES_SIDE * step, map + i * plane + l, LT_BLOCK, plane,
                             lt_min_i64(LT_TILES_SIDE, k - l), lt_min_i64(AT_ONCE, maps - i), NULL);
}

/* A segment of positions of several images, put together */
static void left_segment(const piece *w, lt_real *out, const lt_tile *t, int64_t k0, int64_t k)
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
    const piece *w = ctx;

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

static void pack_x_panel(const piece *w, lt_real *out, const stretch *s, int64_t n0, int64_t n)
{
    const weights_job *j = w->j;
    const lt_real *x = x_of(w, s->image);

    if (conv_pointwise(&j->p)) {
        lt_k->pack_b(out, x + n0 * j->positions + s->at, 1, j->positions, s->n, n);
    } else {
        const lt_conv_image g = conv_window_image(&j->p, x, &j->taps);

        lt_k->pack_image_t(out, &g, s->at, s->n, n0, n);
    }
}

static void pack_x(const void *ctx, lt_real *out, const lt_tile *t, int64_t image, int64_t k0, int64_t k)
{
    const piece *w = ctx;
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
static void turn_windows(const piece *w, lt_real *out, int64_t ld, const stretch *s, int64_t n0, int64_t n)
{
    enum { AT_ONCE = 32, LD = LT_PACK_K + WINDOW_SLACK };
    const lt_conv_image g = conv_window_image(&w->j->p, x_of(w, s->image), &w->j->taps);
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
    const piece *w = ctx;

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

/* One chunk adds to dw, as its chains' beginning; several have a place each. */
static void run_product(void *ctx, int64_t task)
{
    const weights_job *j = ctx;
    const piece w = piece_of(j, task);
    const bool alone = j->chunks == 1 && !j->swapped;
    lt_real *sums = alone ? j->dw : j->part + w.chunk * conv_weight_count(&j->p);
    const lt_product product = {
        .k = (w.to - w.from) * j->positions, .ctx = &w, .pack_a = pack_dy, .pack_b = pack_x,
        .left = j->tiles ? pack_left : NULL, .right = pack_right,
        .c = sums + (w.group * conv_group_o(&j->p) + w.t.m0) * j->n + w.t.n0, .ldc = j->n, .add = alone,
    };

    lt_product_tile(&product, &w.t, 0, 1);
}

enum { RUN = 4096 };

static void add_run(void *ctx, int64_t task)
{
    const weights_job *j = ctx;
    const int64_t n = conv_weight_count(&j->p), at = task * RUN;

    for (int64_t i = 0; i < j->chunks; i++)
        lt_k->add_to(j->dw + at, j->part + i * n + at, (size_t)lt_min_i64(RUN, n - at));
}

static void add_chunks(weights_job *j)
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
                   true);
}

static void by_product(weights_job *j)
{
    lt_parallel_for(j->pieces * j->chunks, run_product, j);
    if (j->swapped)
        lt_parallel_for(lt_ceil_div(j->m, LT_TILES_SIDE), turn_strip, j);
    else if (j->chunks > 1)
        add_chunks(j);
}

/* ---- 1 x 1 with a stride: what it reads of x, as maps of their own --------------------------------------- */

static int64_t sample_count(const lt_conv2d_params *p)
{
    return p->n * p->c * lt_conv2d_out_h(p) * lt_conv2d_out_w(p);
}

typedef struct { const weights_job *j; lt_real *out; } sample_job;

static void sample_channel(void *ctx, int64_t channel)
{
    const sample_job *s = ctx;
    const weights_job *j = s->j;
    const lt_conv_image g = conv_window_image(&j->p, j->x, &j->taps);
    lt_real line[LT_PACK_K + WINDOW_SLACK];

    for (int64_t at = 0; at < j->positions; at += LT_PACK_K) {
        const int64_t n = lt_min_i64(LT_PACK_K, j->positions - at);

        lt_k->image_rows(line, 0, &g, at, n, channel, 1);
        memcpy(s->out + channel * j->positions + at, line, (size_t)n * sizeof(*line));
    }
}

static void by_samples(weights_job *j)
{
    sample_job s = { j, j->part };

    lt_parallel_for(j->p.n * j->p.c, sample_channel, &s);
    j->x = s.out;
    j->part = s.out + sample_count(&j->p);
    j->p.h = lt_conv2d_out_h(&j->p), j->p.w = lt_conv2d_out_w(&j->p);
    j->p.stride_h = j->p.stride_w = 1, j->p.pad_h = j->p.pad_w = 0;
    by_product(j);
}

/* ---- the gradient of the weights ------------------------------------------------------------------------ */

static int64_t depthwise_chunks(const lt_conv2d_params *p)
{
    return lt_min_i64(p->n, MOST_CHUNKS);
}

static int64_t work_elements(const weights_job *j)
{
    const int64_t samples = j->way == BY_SAMPLES ? sample_count(&j->p) : 0;

    if (j->way == BY_WINDOW)
        return j->pieces * j->chunks * j->tile_m * j->tile_n;
    return samples + (j->chunks > 1 || j->swapped ? j->chunks * conv_weight_count(&j->p) : 0);
}

size_t lt_conv2d_weights_work(const lt_conv2d_params *p)
{
    weights_job j = { .p = *p };

    if (conv_nothing(p))
        return 0;
    if (conv_group_c(p) == 1)
        return (size_t)(depthwise_chunks(p) * conv_weight_count(p)) * sizeof(lt_real);
    if (lt_winograd_weights_suits(p))
        return lt_winograd_weights_work(p);
    cut(&j);
    return (size_t)work_elements(&j) * sizeof(lt_real);
}

void lt_conv2d_backward_weights(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy,
                                lt_real *dw, void *work)
{
    weights_job j = { .p = *p, .x = x, .dy = dy, .dw = dw, .part = work };

    if (conv_nothing(p))
        return;
    cut(&j);
    if (conv_group_c(p) == 1) {
        j.chunks = depthwise_chunks(p);
        lt_depthwise_backward_weights(p, x, dy, j.chunks, work);
        add_chunks(&j);
    } else if (lt_winograd_weights_suits(p)) {
        lt_winograd_weights_run(p, x, dy, dw, work);
    } else if (j.way == BY_WINDOW) {
        by_windows(&j);
    } else if (j.way == BY_SAMPLES) {
        by_samples(&j);
    } else {
        by_product(&j);
    }
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
