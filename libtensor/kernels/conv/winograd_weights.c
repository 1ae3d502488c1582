/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/conv/winograd_weights.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/winograd.h"
#include "libtensor/kernels/gemm/product.h"

#include <string.h>

enum {
    SIDE = 4,                   /* of a tile of dy; of x it has two more */
    ACROSS = SIDE + 2,
    PLACES = ACROSS * ACROSS,
    MOST_POSITIONS = 1280,      /* of the part of a map that a task turns */
    BAND_TILES = 64,            /* of that part, where they can be had */
    ROUND_TILES = LT_PACK_K,    /* of all images, at a time */
    SUMS_BYTES = 10 << 20,      /* of sums at a time: they should stay in the cache, */
    SUMS_CHANNELS = 64,         /* of a multiple of so many output channels */
    APART = 16,                 /* between places and rows, or all of them would fall into one set of each cache */
};

/* Maps are taken in bands of some rows of tiles, and some bands at a time. */
typedef struct {
    const lt_conv2d_params *p;
    const lt_real *x, *dy;
    bool add;                           /* to what dw holds; else it holds garbage */
    lt_real *dw;
    lt_real *in, *grad, *sums;          /* [place][tile][c]; [place][panel of nr][tile][nr]; [place][c][o] */
    int64_t in_ld, sums_ld;
    int64_t in_place, grad_place, sums_place;
    int64_t in_blocks, grad_blocks;     /* of LT_BLOCK channels */
    int64_t wide, high;                 /* tiles of a row; rows of tiles of an image */
    int64_t band, bands;                /* rows of tiles of a band; bands of an image */
    int64_t first, count, most;         /* bands of this round, and of the largest one */
    int64_t row, tiles;                 /* the first row of tiles of this round, counted over all images; its tiles */
    int64_t o0, o, most_o;              /* output channels that are summed now, and the most */
} job;

/* Where a band lies: its image, and its rows of tiles. */
typedef struct { int64_t image, row, rows; } band;

static band band_at(const job *j, int64_t i)
{
    const int64_t row = i % j->bands * j->band;

    return (band){ i / j->bands, row, lt_min_i64(j->band, j->high - row) };
}

/* Rows of tiles before band i, over all images */
static int64_t rows_before(const job *j, int64_t i)
{
    return i / j->bands * j->high + i % j->bands * j->band;
}

/* Of a part that is so many rows of tiles high */
static int64_t positions(int64_t rows, int64_t w)
{
    return (rows * SIDE + 2) * w;
}

bool lt_winograd_weights_suits(const lt_conv2d_params *p)
{
    enum { SMALL = 8, FEW_TILES = 16 };     /* the sums' way back costs as much as a dozen tiles */

    return lt_winograd_form(p) && p->h >= SMALL && p->w >= SMALL
           && p->n * lt_ceil_div(p->h, SIDE) * lt_ceil_div(p->w, SIDE) >= FEW_TILES
           && positions(1, p->w) <= MOST_POSITIONS;
}

/* Sums of several rounds stay; those of a single one are made and used some output channels at a time. */
static int64_t channels_at_once(const lt_conv2d_params *p, bool single)
{
    const int64_t most = SUMS_BYTES / (PLACES * p->c * (int64_t)sizeof(float)) / SUMS_CHANNELS * SUMS_CHANNELS;

    return single ? lt_tile_size(p->o, lt_max_i64(SUMS_CHANNELS, most), SUMS_CHANNELS) : p->o;
}

static int64_t whole_blocks(int64_t n, int64_t unit)
{
    return lt_ceil_div(n, unit) * unit;
}

static job plan(const lt_conv2d_params *p)
{
    job j = { .p = p, .wide = lt_ceil_div(p->w, SIDE), .high = lt_ceil_div(p->h, SIDE) };
    int64_t tiles;

    j.band = lt_min_i64(j.high, lt_max_i64(1, BAND_TILES / j.wide));
    while (positions(j.band, p->w) > MOST_POSITIONS)
        j.band--;
    j.bands = lt_ceil_div(j.high, j.band);
    j.band = lt_ceil_div(j.high, j.bands);
    tiles = j.band * j.wide;
    j.most = lt_min_i64(p->n * j.bands, lt_max_i64(1, ROUND_TILES / tiles));
    j.most_o = channels_at_once(p, j.most == p->n * j.bands);
    j.in_blocks = lt_ceil_div(p->c, LT_BLOCK);
    j.grad_blocks = lt_ceil_div(p->o, LT_BLOCK);
    j.in_ld = j.in_blocks * LT_BLOCK + APART;
    j.sums_ld = whole_blocks(j.most_o, LT_BLOCK) + APART;
    j.in_place = j.most * tiles * j.in_ld + APART;
    j.grad_place = j.most * tiles * whole_blocks(p->o, lt_max_i64(lt_k->nr, LT_BLOCK)) + APART;
    j.sums_place = p->c * j.sums_ld + APART;
    return j;
}

/* ---- maps --------------------------------------------------------------------------------------------- */

/* Rows [y0, y0 + rows) of a map, as far as there are, turned to [position][LT_BLOCK]; 0 in lanes without a channel */
typedef struct { int64_t y0, rows; lt_real at[MOST_POSITIONS * LT_BLOCK]; } part;

static void turn_part(part *t, const lt_conv2d_params *p, const lt_real *map, int64_t channels, int64_t from,
                      int64_t to)
{
    t->y0 = lt_max_i64(0, from);
    t->rows = lt_min_i64(p->h, to) - t->y0;
    if (channels < LT_BLOCK)
        memset(t->at, 0, sizeof(t->at));
    lt_k->turn(t->at, LT_BLOCK, map + t->y0 * p->w, p->h * p->w, channels, t->rows * p->w, false);
}

static int64_t channels_of(int64_t n, int64_t from)
{
    return lt_min_i64(LT_BLOCK, n - from);
}

/* Some channels of x in one band */
static void transform_input(const job *j, int64_t at, int64_t c)
{
    const lt_conv2d_params *p = j->p;
    const band b = band_at(j, j->first + at);
    lt_real *out = j->in + (b.image * j->high + b.row - j->row) * j->wide * j->in_ld + c;
    part t;

    turn_part(&t, p, j->x + (b.image * p->c + c) * p->h * p->w, channels_of(p->c, c), b.row * SIDE - 1,
              (b.row + b.rows) * SIDE + 1);
    for (int64_t i = 0; i < b.rows * j->wide; i++, out += j->in_ld) {
        const int64_t y = (b.row + i / j->wide) * SIDE - t.y0, x = i % j->wide * SIDE;
        const lt_real *d[PLACES];

        lt_winograd_look(d, t.at, t.rows, p->w, y - 1, x - 1, ACROSS);
        lt_k->wino_block_input(out, j->in_place, d);
    }
}

/* Some channels of dy in one band */
static void transform_grad(const job *j, int64_t at, int64_t o)
{
    const lt_conv2d_params *p = j->p;
    const band b = band_at(j, j->first + at);
    const int64_t nr = lt_k->nr, panel = j->tiles * nr;
    lt_real *out = j->grad + o / nr * panel + (b.image * j->high + b.row - j->row) * j->wide * nr + o % nr;
    part t;

    turn_part(&t, p, j->dy + (b.image * p->o + o) * p->h * p->w, channels_of(p->o, o), b.row * SIDE,
              (b.row + b.rows) * SIDE);
    for (int64_t i = 0; i < b.rows * j->wide; i++, out += nr) {
        const int64_t y = (b.row + i / j->wide) * SIDE - t.y0, x = i % j->wide * SIDE;
        const lt_real *d[SIDE * SIDE];

        lt_winograd_look(d, t.at, t.rows, p->w, y, x, SIDE);
        lt_k->wino_block_grad(out, j->grad_place, panel, d);
    }
}

static void transform(void *ctx, int64_t task)
{
    const job *j = ctx;
    const int64_t blocks = j->in_blocks + j->grad_blocks, block = task % blocks;

    if (block < j->in_blocks)
        transform_input(j, task / blocks, block * LT_BLOCK);
    else
        transform_grad(j, task / blocks, (block - j->in_blocks) * LT_BLOCK);
}

/* ---- products and windows -------------------------------------------------------------------------------- */

/* One panel of output channels in one place */
static void multiply(void *ctx, int64_t task)
{
    const job *j = ctx;
    const int64_t nr = lt_k->nr, panels = lt_ceil_div(j->o, nr), place = task / panels, at = task % panels * nr;

    lt_k->gemm_columns(j->sums + place * j->sums_place + at, j->sums_ld, j->in + place * j->in_place, j->in_ld,
                       j->grad + place * j->grad_place + (j->o0 + at) * j->tiles, j->p->c,
                       lt_min_i64(nr, j->o - at), j->tiles, j->first > 0, NULL);
}

/* A block of output channels of a block of input channels */
static void transform_sums(void *ctx, int64_t task)
{
    const job *j = ctx;
    const int64_t blocks = lt_ceil_div(j->o, LT_BLOCK), k = j->p->c * 9;
    const int64_t c = task / blocks * LT_BLOCK, at = task % blocks * LT_BLOCK, n = channels_of(j->p->c, c);
    lt_real windows[LT_BLOCK * 9 * LT_BLOCK];

    for (int64_t i = 0; i < n; i++)
        lt_k->wino_block_windows(windows + i * 9 * LT_BLOCK, j->sums + (c + i) * j->sums_ld + at, j->sums_place);
    lt_k->turn(j->dw + (j->o0 + at) * k + c * 9, k, windows, LT_BLOCK, n * 9, channels_of(j->o, at), j->add);
}

static void sum_round(job *j)
{
    const bool last = j->first + j->count == j->p->n * j->bands;

    for (j->o0 = 0; j->o0 < j->p->o; j->o0 += j->most_o) {
        j->o = lt_min_i64(j->most_o, j->p->o - j->o0);
        lt_parallel_for(PLACES * lt_ceil_div(j->o, lt_k->nr), multiply, j);
        if (last)
            lt_parallel_for(j->in_blocks * lt_ceil_div(j->o, LT_BLOCK), transform_sums, j);
    }
}

/* ---- all of it ------------------------------------------------------------------------------------------ */

size_t lt_winograd_weights_work(const lt_conv2d_params *p)
{
    const job j = plan(p);

    return (size_t)(PLACES * (j.in_place + j.grad_place + j.sums_place)) * sizeof(lt_real);
}

void lt_winograd_weights_run(const lt_conv2d_params *p, const lt_real *x, const lt_real *dy, bool add, lt_real *dw,
                             void *work)
{
    job j = plan(p);
    const int64_t all = p->n * j.bands;

    j.x = x, j.dy = dy, j.add = add, j.dw = dw;
    j.in = work, j.grad = j.in + PLACES * j.in_place, j.sums = j.grad + PLACES * j.grad_place;
    for (j.first = 0; j.first < all; j.first += j.most) {
        j.count = lt_min_i64(j.most, all - j.first);
        j.row = rows_before(&j, j.first);
        j.tiles = (rows_before(&j, j.first + j.count) - j.row) * j.wide;
        lt_parallel_for(j.count * (j.in_blocks + j.grad_blocks), transform, &j);
        sum_round(&j);
    }
}
