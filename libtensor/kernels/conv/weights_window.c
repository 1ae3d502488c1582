/* SPDX-License-Identifier: Apache-2.0 */
/* The gradient of a convolution's weights by windows: vectors of dy's channels, a sum for each tap of x's. */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/weights.h"

/* ---- bands --------------------------------------------------------------------------------------------- */

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
    b->channel = images * b->lines * b->line + LT_WEIGHTS_SLACK;
}

static bool fits(const window_band *b)
{
    return b->channel * LT_WEIGHTS_CHANNELS <= LT_SCRATCH_A;
}

static bool windows_suit(const lt_conv2d_params *p)
{
    return (p->kh == 3 || p->kh == 5 || p->kh == 7) && p->kw == p->kh && p->dil_h == 1 && p->dil_w == 1
           && p->stride_h == p->stride_w;
}

window_band conv_weights_band(const lt_conv2d_params *p)
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

/* ---- sums ---------------------------------------------------------------------------------------------- */

static lt_real *window_tile(const weights_piece *w)
{
    return w->j->part + w->task * w->j->tile_m * w->j->tile_n;          /* (tile_m, tile_n) */
}

/* The lines of x under a band of output rows from `row` on, with their zeros. */
static void copy_lines(const weights_piece *w, lt_real *out, int64_t image, int64_t channel, int64_t channels,
                       int64_t row, int64_t rows)
{
    const lt_conv2d_params *p = &w->j->p;
    const int64_t line = w->j->band.line;
    const lt_tap corner = { (int)(row * p->stride_h) - p->pad_h, -p->pad_w };
    const lt_conv_image g = { weights_x(w, image), p->h, p->w, line, 1, 1, 1, &corner };

    lt_k->image_rows(out, w->j->band.channel, &g, 0, span(rows, p->stride_h, p->kh) * line, channel, channels);
}

/* out[panel][row + position][lane], `rows` rows in all: n positions of the tile's channels of dy, turned. */
static void turn_lanes(const weights_piece *w, lt_real *out, const lt_real *dy, int64_t rows, int64_t row, int64_t n)
{
    const int nr = lt_k->nr;

    for (int64_t o = 0; o < w->t.n; o += nr)
        lt_k->pack_b(out + o * rows + row * nr, dy + o * w->j->positions, 1, w->j->positions, n,
                     lt_min_i64(nr, w->t.n - o));
}

/* The windows at `rows` rows from `row` on of `images` images: x goes to a, dy to b. */
static void band_sums(const weights_piece *w, lt_real *a, lt_real *b, int64_t image, int64_t images, int64_t row,
                      int64_t rows)
{
    const weights_job *j = w->j;
    const int64_t cols = lt_conv2d_out_w(&j->p), n = rows * cols, each = j->band.lines * j->band.line;
    const int64_t taps = j->taps.n, channel = w->t.m0 / taps, channels = w->t.m / taps;
    lt_window g = { a, each, j->band.line, images, rows, cols, j->p.stride_h, j->p.kh };

    for (int64_t i = 0; i < images; i++) {
        copy_lines(w, a + i * each, image + i, channel, channels, row, rows);
        turn_lanes(w, b, weights_dy(w, image + i) + w->t.n0 * j->positions + row * cols, images * n, i * n, n);
    }
    for (int64_t o = 0; o < w->t.n; o += lt_k->nr)
        for (int64_t c = 0; c < channels; c++) {
            g.x = a + c * j->band.channel;
            lt_k->window_sums(window_tile(w) + c * taps * j->tile_n + o, j->tile_n, &g, b + o * images * n,
                              lt_min_i64(lt_k->nr, w->t.n - o), image > w->from || row > 0);
        }
}

static void add_window_tile(const weights_piece *w, bool add)
{
    const weights_job *j = w->j;
    const int64_t k = conv_group_c(&j->p) * j->taps.n, o = w->group * conv_group_o(&j->p) + w->t.n0;

    lt_k->turn(j->dw + o * k + w->t.m0, k, window_tile(w), j->tile_n, w->t.m, w->t.n, add);
}

static void window_task(void *ctx, lt_real *a, lt_real *b)
{
    const weights_piece *w = ctx;
    const window_band *band = &w->j->band;
    const int64_t h = lt_conv2d_out_h(&w->j->p);

    for (int64_t image = w->from; image < w->to; image += band->images)
        for (int64_t row = 0; row < h; row += band->rows)
            band_sums(w, a, b, image, lt_min_i64(band->images, w->to - image), row, lt_min_i64(band->rows, h - row));
    if (w->j->chunks == 1)
        add_window_tile(w, w->j->add);
}

static void run_window(void *ctx, int64_t task)
{
    weights_piece w = weights_piece_of(ctx, task);

    lt_with_scratch(window_task, &w);
}

static void add_window_chunks(void *ctx, int64_t tile)
{
    const weights_job *j = ctx;

    for (int64_t i = 0; i < j->chunks; i++) {
        const weights_piece w = weights_piece_of(j, tile * j->chunks + i);

        add_window_tile(&w, j->add || i > 0);
    }
}

void conv_weights_by_windows(weights_job *j)
{
    lt_parallel_for(j->pieces * j->chunks, run_window, j);
    if (j->chunks > 1)
        lt_parallel_for(j->pieces, add_window_chunks, j);
}

