/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/conv/winograd2.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/turned.h"
#include "libtensor/kernels/conv/winograd.h"
#include "libtensor/kernels/gemm/product.h"

#include <string.h>

enum {
    PLACES = 16,
    SIDE = 11, MOST_TILES = 36, /* of the largest map */
    LANES = LT_BLOCK,           /* channels that are transformed at once ... */
    CHANNELS = 64,              /* ... and brought back */
    APART = 16,                 /* elements, so that places do not share lines of the cache */
};

static int64_t tiles_of(const lt_conv2d_params *p)
{
    return lt_ceil_div(p->h, 2) * lt_ceil_div(p->w, 2);
}

bool lt_winograd2_suits(const lt_conv2d_params *p)
{
    enum { SMALL = 36 };

    return lt_winograd_form(p) && p->h <= SIDE && p->w <= SIDE && p->h * p->w >= SMALL
           && 3 * tiles_of(p) <= p->h * p->w;
}

/* ---- windows: [place][panel of nr][k][nr] ---- */

typedef struct {
    lt_windows all;
    int64_t m, k;
    lt_real *packed;
} window_job;

static int64_t packed_place(int64_t m, int64_t k)
{
    return lt_product_packed_b(m, k) + APART;
}

static int64_t packed_elements(const lt_conv2d_params *p, conv_direction d)
{
    return PLACES * packed_place(conv_maps_out(p, d), conv_maps_in(p, d));
}

static void pack_panel(void *ctx, int64_t panel)
{
    const window_job *j = ctx;
    const int64_t nr = lt_k->nr, m0 = panel * nr;
    lt_windows g = j->all;

    g.w += m0 * g.row;
    lt_k->wino2_windows(j->packed + m0 * j->k, packed_place(j->m, j->k), nr, &g, lt_min_i64(nr, j->m - m0), j->k);
}

static void pack(const lt_conv2d_params *p, conv_direction d, const lt_real *weights, lt_real *packed)
{
    window_job j = { lt_winograd_windows(p, d, weights), conv_maps_out(p, d), conv_maps_in(p, d), packed };

    lt_parallel_for(lt_ceil_div(j.m, lt_k->nr), pack_panel, &j);
}

/* ---- maps ---- */

typedef struct {
    const lt_conv2d_params *p;
    int64_t m, k;
    const lt_real *x, *packed;
    const lt_conv2d_around *around;
    lt_real *y, *in, *out;              /* in: [place][k][tile], out: [place][tile][m], tiles of all images */
    int64_t across, each, tiles;        /* tiles of a row, of an image, of all */
    int64_t in_place, out_place, ld;    /* from place to place; from tile to tile of out */
    int64_t rows, parts;                /* tiles that a task multiplies; so many parts of all */
} wino2_job;

static void plan(wino2_job *j, const lt_conv2d_params *p, conv_direction d)
{
    const int64_t m = conv_maps_out(p, d), k = conv_maps_in(p, d), panels = lt_ceil_div(m, lt_k->nr);

    *j = (wino2_job){ .p = p, .m = m, .k = k, .across = lt_ceil_div(p->w, 2), .each = tiles_of(p),
                      .ld = lt_ceil_div(m, LANES) * LANES + APART };
    j->tiles = p->n * j->each;
    j->in_place = k * j->tiles + APART;
    j->out_place = j->tiles * j->ld + APART;
    j->rows = lt_turned_rows(j->tiles, PLACES * panels);
    j->parts = lt_ceil_div(j->tiles, j->rows);
}

static size_t work_bytes(const lt_conv2d_params *p, conv_direction d)
{
    wino2_job j;

    plan(&j, p, d);
    return (size_t)(PLACES * (j.in_place + j.out_place)) * sizeof(lt_real);
}

/* LANES channels of an image */
static void transform_input(void *ctx, int64_t task)
{
    const wino2_job *j = ctx;
    const int64_t blocks = lt_ceil_div(j->k, LANES), image = task / blocks, c = task % blocks * LANES;
    const int64_t n = lt_min_i64(LANES, j->k - c), positions = j->p->h * j->p->w;
    _Alignas(LT_ALIGN) lt_real map[SIDE * SIDE * LANES] = { 0 }, out[PLACES * MOST_TILES * LANES];

    lt_k->turn(map, LANES, j->x + (image * j->k + c) * positions, positions, n, positions, false);
    for (int64_t t = 0; t < j->each; t++) {
        const lt_real *d[PLACES];

        lt_winograd_look(d, map, j->p->h, j->p->w, t / j->across * 2 - 1, t % j->across * 2 - 1, 4);
        lt_k->wino2_input(out + t * LANES, MOST_TILES * LANES, d);
    }
    for (int i = 0; i < PLACES; i++)
        lt_k->turn(j->in + i * j->in_place + c * j->tiles + image * j->each, j->tiles, out + i * MOST_TILES * LANES,
                   LANES, j->each, n, false);
}

/* The tiles of one panel follow each other. */
static void multiply(void *ctx, int64_t task)
{
    const wino2_job *j = ctx;
    const int64_t panels = lt_ceil_div(j->m, lt_k->nr), from = task % j->parts * j->rows;
    const int64_t at = task / j->parts % panels * lt_k->nr, place = task / j->parts / panels;

    lt_turned_product(j->out + place * j->out_place + from * j->ld + at, j->ld, j->in + place * j->in_place + from,
                      j->tiles, j->packed + place * packed_place(j->m, j->k) + at * j->k,
                      lt_min_i64(j->rows, j->tiles - from), lt_min_i64(lt_k->nr, j->m - at), j->k, NULL);
}

/* Some channels of an image; `sums` is [position][CHANNELS] */
static void gather_tiles(const wino2_job *j, int64_t image, int64_t m0, int64_t n, lt_real *sums)
{
    const int64_t h = j->p->h, w = j->p->w;
    lt_real beside[CHANNELS];

    for (int64_t t = 0; t < j->each; t++) {
        const int64_t y = t / j->across * 2, x = t % j->across * 2;
        lt_real *to[4];

        for (int i = 0; i < 4; i++)
            to[i] = y + i / 2 < h && x + i % 2 < w ? sums + ((y + i / 2) * w + x + i % 2) * CHANNELS : beside;
        lt_k->wino2_output(to, j->out + (image * j->each + t) * j->ld + m0, j->out_place, n);
    }
}

static void transform_output(void *ctx, int64_t task)
{
    const wino2_job *j = ctx;
    const lt_conv2d_around *around = j->around;
    const int64_t blocks = lt_ceil_div(j->m, CHANNELS), image = task / blocks, m0 = task % blocks * CHANNELS;
    const int64_t n = lt_min_i64(CHANNELS, j->m - m0), positions = j->p->h * j->p->w;
    const int64_t at = (image * j->m + m0) * positions;
    const lt_epilogue e = { .col_bias = around->bias ? around->bias + m0 : NULL,
                            .act = around->residual ? (lt_act){ LT_ACT_NONE, 0 } : around->act };
    _Alignas(LT_ALIGN) lt_real sums[SIDE * SIDE * CHANNELS];

    gather_tiles(j, image, m0, n, sums);
    lt_k->epilogue(sums, CHANNELS, positions, n, &e);
    lt_turned_place(j->y + at, positions, around->residual ? around->residual + at : NULL, around->act, sums, CHANNELS,
                    positions, n);
}

static void run(const lt_conv2d_params *p, conv_direction d, const lt_real *x, const lt_real *packed,
                const lt_conv2d_around *around, lt_real *y, void *work)
{
    wino2_job j;

    plan(&j, p, d);
    j.x = x, j.packed = packed, j.around = around, j.y = y;
    j.in = work, j.out = j.in + PLACES * j.in_place;
    lt_parallel_for(p->n * lt_ceil_div(j.k, LANES), transform_input, &j);
    lt_parallel_for(PLACES * lt_ceil_div(j.m, lt_k->nr) * j.parts, multiply, &j);
    lt_parallel_for(p->n * lt_ceil_div(j.m, CHANNELS), transform_output, &j);
}

const conv_way conv_winograd2 = { packed_elements, pack, work_bytes, run };
