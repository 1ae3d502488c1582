/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/conv/winograd.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/gemm/product.h"

#include <string.h>

enum {
    PLACES = 36,
    MOST_TILES = 512,           /* of a band: what a task holds on its stack */
    MOST_DEALT = 768,           /* the same with the row below the band */
    BAND_TILES = 64,           /* of a band, where that can be had */
    SLACK = 64,                 /* lines are dealt and gathered by whole vectors */
    COLUMNS = 512,              /* of one task's product */
    ROUND_BYTES = 3 << 20,      /* of transformed maps at a time: they should stay in the cache */
    LANES = 16,                 /* tiles of a band are counted up to a multiple of these */
    APART = 16,                 /* between places, or all of them would fall into one set of each cache */
};

/* A part of a map, h x w from (y0, x0), as tiles: `high` rows of `wide`, taken in bands of `band` rows. */
typedef struct {
    int64_t map_h, map_w, y0, x0, h, w, high, wide, band;
    int64_t bands;              /* of an image */
    int64_t columns;            /* of a band */
} tiling;

typedef struct {
    tiling t;
    int64_t m, k, first, bands;         /* of one round, over all images */
    const lt_real *x, *packed;
    const lt_epilogue *e;
    lt_real *y, *in, *out;              /* in: panels [place][panel][k][nr]; out: [place][m][column] */
} job;

bool lt_winograd_form(const lt_conv2d_params *p)
{
    enum { FEW = 32 };

    return p->kh == 3 && p->kw == 3 && p->stride_h == 1 && p->stride_w == 1 && p->pad_h == 1 && p->pad_w == 1
           && p->dil_h == 1 && p->dil_w == 1 && p->groups == 1 && p->c >= FEW && p->o >= FEW;
}

void lt_winograd_look(const lt_real **d, const lt_real *map, int64_t h, int64_t w, int64_t y, int64_t x, int size)
{
    static const lt_real none[LT_BLOCK];

    for (int i = 0; i < size * size; i++) {
        const int64_t row = y + i / size, col = x + i % size;

        d[i] = row < 0 || row >= h || col < 0 || col >= w ? none : map + (row * w + col) * LT_BLOCK;
    }
}

static tiling tiles_of(const lt_conv2d_params *p, lt_rect r)
{
    tiling t = { .map_h = p->h, .map_w = p->w, .y0 = r.y0, .x0 = r.x0, .h = r.y1 - r.y0, .w = r.x1 - r.x0 };

    t.high = lt_ceil_div(t.h, 4);
    t.wide = lt_ceil_div(t.w, 4);
    t.band = lt_min_i64(t.high, lt_max_i64(1, BAND_TILES / t.wide));
    t.bands = lt_ceil_div(t.high, t.band);
    t.band = lt_ceil_div(t.high, t.bands);
    t.columns = lt_ceil_div(t.band * t.wide, LANES) * LANES;
    return t;
}

bool lt_winograd_suits(const lt_conv2d_params *p)
{
    tiling t;

    if (!lt_winograd_form(p) || p->h < 12 || p->w < 12)
        return false;
    t = tiles_of(p, lt_conv2d_all(p));
    return t.columns <= MOST_TILES && (t.band + 1) * t.wide <= MOST_DEALT;
}

/* ---- windows --------------------------------------------------------------------------------------- */

typedef struct {
    lt_windows all;
    int64_t m, k;
    lt_real *packed;
} window_job;

static int64_t packed_elements(const lt_conv2d_params *p, conv_direction d)
{
    (void)d;
    return PLACES * p->o * p->c;
}

/* One panel of rows, one block of k, in all places: [place][block][panel] */
static void pack_panel(void *ctx, int64_t task)
{
    const window_job *j = ctx;
    const int64_t panels = lt_ceil_div(j->m, lt_k->mr), panel = task % panels;
    const int64_t blocks = lt_product_blocks(j->k), block = task / panels;
    const int64_t m0 = panel * j->m / panels, rows = (panel + 1) * j->m / panels - m0;
    const int64_t k0 = block * j->k / blocks, k = (block + 1) * j->k / blocks - k0;
    lt_windows g = j->all;

    g.w += m0 * g.row + k0 * g.col;
    lt_k->wino_windows(j->packed + k0 * j->m + m0 * k, j->m * j->k, rows, &g, rows, k);
}

static void pack(const lt_conv2d_params *p, conv_direction d, const lt_real *weights, lt_real *packed)
{
    window_job j = { lt_winograd_windows(p, d, weights), conv_maps_out(p, d), conv_maps_in(p, d), packed };

    lt_parallel_for(lt_ceil_div(j.m, lt_k->mr) * lt_product_blocks(j.k), pack_panel, &j);
}

/* Elements from one place to the next: of panels of the maps, of the products. */
static int64_t in_place(int64_t bands, const tiling *t, int64_t k)
{
    return k * lt_ceil_div(bands * t->columns, lt_k->nr) * lt_k->nr + APART;
}

static int64_t out_place(int64_t bands, const tiling *t, int64_t m)
{
    return m * bands * t->columns + APART;
}

/* ---- input ------------------------------------------------------------------------------------------ */

/* Rows 4 ty + i of the part and what borders on it, i < 4, dealt to q[i][j][ty][tx]: column 4 tx + j, j < 6. What the
 * last tiles have beyond that is 0: nobody may have written it. The same rows of the next plane, which comes next, are
 * fetched meanwhile. */
static void deal_band(const tiling *t, const lt_real *plane, int64_t ty0, int64_t rows, lt_real *q,
                      int64_t phase)
{
    enum { LINE = LT_ALIGN / (int)sizeof(lt_real) };
    const int64_t left = lt_max_i64(0, t->x0 - 1), right = lt_min_i64(t->map_w, t->x0 + t->w + 1);
    const int64_t below = lt_min_i64(t->map_h, t->y0 + t->h + 1);
    const size_t bytes = (size_t)(right - left) * sizeof(lt_real);
    lt_real line[4 * MOST_TILES + 2 * SLACK], *inner = line + left - (t->x0 - 1);

    memset(line, 0, (size_t)(4 * t->wide + 2 * SLACK) * sizeof(lt_real));
    for (int64_t r = 0; r < 4 * rows + 2; r++) {
        const int64_t y = t->y0 + 4 * ty0 + r - 1;
        const lt_real *row = plane + y * t->map_w + left;

        if (y >= 0 && y < below) {
            for (int64_t i = 0; i < right - left; i += LINE)
                __builtin_prefetch(row + t->map_h * t->map_w + i);
            memcpy(inner, row, bytes);
        } else {
            memset(inner, 0, bytes);
        }
        lt_k->wino_deal(q + r % 4 * 6 * phase + r / 4 * t->wide, phase, line, t->wide);
    }
}

/* Where a band of the round lies: its image, and its rows of tiles. */
typedef struct { int64_t image, ty, rows; } place_of_band;

static place_of_band band_of(const job *j, int64_t i)
{
    const int64_t at = j->first + i, ty = at % j->t.bands * j->t.band;

    return (place_of_band){ at / j->t.bands, ty, lt_min_i64(j->t.band, j->t.high - ty) };
}

/* One channel of one band. */
static void transform_input(void *ctx, int64_t task)
{
    const job *j = ctx;
    const tiling *t = &j->t;
    const int64_t c = task % j->k, panel = j->k * lt_k->nr, phase = (t->band + 1) * t->wide + SLACK;
    const place_of_band b = band_of(j, task / j->k);
    const lt_real *plane = j->x + (b.image * j->k + c) * t->map_h * t->map_w;
    lt_real q[24 * (MOST_DEALT + SLACK)];

    if (b.rows * t->wide < t->columns)          /* columns without a tile */
        memset(q, 0, (size_t)(24 * phase) * sizeof(lt_real));
    deal_band(t, plane, b.ty, b.rows, q, phase);
    lt_k->wino_input(j->in + c * lt_k->nr, in_place(j->bands, t, j->k), panel, task / j->k * t->columns, q, phase,
                     t->wide, t->columns);
}

/* ---- product ---------------------------------------------------------------------------------------- */

static void multiply(void *ctx, int64_t task)
{
    const job *j = ctx;
    const int64_t place = task % PLACES, nr = lt_k->nr, blocks = lt_product_blocks(j->k);
    const int64_t columns = j->bands * j->t.columns, from = task / PLACES * COLUMNS;
    const int64_t to = lt_min_i64(columns, from + COLUMNS);
    const lt_real *a = j->packed + place * j->m * j->k;
    const lt_real *b = j->in + place * in_place(j->bands, &j->t, j->k);
    lt_real *c = j->out + place * out_place(j->bands, &j->t, j->m);

    for (int64_t i = 0; i < blocks; i++) {
        const int64_t k0 = i * j->k / blocks, k = (i + 1) * j->k / blocks - k0;

        lt_k->gemm_block(c + from, columns, a + k0 * j->m, b + from * j->k + k0 * nr, nr * j->k, j->m,
                         to - from, k, i > 0, NULL);
    }
}

/* ---- output ------------------------------------------------------------------------------------------ */

/* Rows [4 ty, 4 ty + rows) of a plane from the phases of its band's tiles, each overwriting what the last one wrote too
 * much: up to SLACK elements. */
static void gather_band(const tiling *t, const lt_real *r, int64_t phase, int64_t rows, lt_real *out)
{
    for (int64_t y = 0; y < rows; y++)
        lt_k->wino_gather(out + y * t->w, r + y % 4 * 4 * phase + y / 4 * t->wide, phase, t->wide);
}

/* What follows the sum, and the way to the map, for n elements that lie side by side there. */
static void finish(const job *j, int64_t o, int64_t at, lt_real *values, int64_t n)
{
    lt_epilogue e = *j->e;

    e.row_bias = e.row_bias ? e.row_bias + o : NULL;
    e.residual = e.residual ? e.residual + at : NULL;
    lt_k->epilogue(values, n, 1, n, &e);
    memcpy(j->y + at, values, (size_t)n * sizeof(lt_real));
}

/* One channel of one band. */
static void transform_output(void *ctx, int64_t task)
{
    const job *j = ctx;
    const tiling *t = &j->t;
    const place_of_band b = band_of(j, task / j->m);
    const int64_t o = task % j->m, columns = j->bands * t->columns, phase = t->columns + SLACK;
    const int64_t plane = (b.image * j->m + o) * t->map_h * t->map_w;
    const int64_t rows = lt_min_i64(4 * b.rows, t->h - 4 * b.ty);
    const int64_t n = t->w == t->map_w ? rows : 1;              /* rows at a time */
    lt_real r[16 * (MOST_TILES + SLACK)], values[16 * MOST_TILES + SLACK];

    lt_k->wino_output(r, phase, j->out + o * columns + task / j->m * t->columns,
                      out_place(j->bands, t, j->m), t->columns);
    gather_band(t, r, phase, rows, values);
    for (int64_t y = 0; y < rows; y += n)
        finish(j, o, plane + (t->y0 + 4 * b.ty + y) * t->map_w + t->x0, values + y * t->w, n * t->w);
}

/* ---- all of it --------------------------------------------------------------------------------------- */

/* Of n images */
static int64_t round_bands(int64_t n, const tiling *t, int64_t m, int64_t k)
{
    const int64_t bytes = PLACES * (m + k) * t->columns * (int64_t)sizeof(float);

    return lt_max_i64(1, lt_min_i64(n * t->bands, ROUND_BYTES / bytes));
}

static size_t work_of(int64_t n, const tiling *t, int64_t m, int64_t k)
{
    const int64_t bands = round_bands(n, t, m, k);

    return (size_t)(PLACES * (in_place(bands, t, k) + out_place(bands, t, m))) * sizeof(lt_real);
}

static size_t work_bytes(const lt_conv2d_params *p, conv_direction d)
{
    const tiling t = tiles_of(p, lt_conv2d_all(p));

    return work_of(p->n, &t, conv_maps_out(p, d), conv_maps_in(p, d));
}

size_t lt_winograd_rect_work(const lt_conv2d_params *p)
{
    size_t most = 0;

    for (int64_t h = 1; h <= p->h; h++)
        for (int64_t w = 1; w <= p->w; w++) {
            const tiling t = tiles_of(p, (lt_rect){ 0, h, 0, w });
            const size_t work = work_of(1, &t, p->o, p->c);

            most = work > most ? work : most;
        }
    return most;
}

static void run_rounds(job *j, int64_t n, void *work)
{
    const int64_t bands = round_bands(n, &j->t, j->m, j->k), all = n * j->t.bands;

    j->in = work;
    j->out = j->in + PLACES * in_place(bands, &j->t, j->k);
    for (j->first = 0; j->first < all; j->first += bands) {
        j->bands = lt_min_i64(bands, all - j->first);
        lt_parallel_for(j->k * j->bands, transform_input, j);
        lt_parallel_for(PLACES * lt_ceil_div(j->bands * j->t.columns, COLUMNS), multiply, j);
        lt_parallel_for(j->m * j->bands, transform_output, j);
    }
}

static void run(const lt_conv2d_params *p, conv_direction d, const lt_real *x, const lt_real *packed,
                const lt_conv2d_around *around, lt_real *y, void *work)
{
    const lt_epilogue e = { .row_bias = around->bias, .residual = around->residual, .act = around->act };
    job j = {
        .t = tiles_of(p, lt_conv2d_all(p)), .m = conv_maps_out(p, d), .k = conv_maps_in(p, d), .x = x,
        .packed = packed, .e = &e, .y = y,
    };

    run_rounds(&j, p->n, work);
}

void lt_winograd_run_rect(const lt_conv2d_params *p, lt_rect r, const lt_real *x, const lt_real *packed,
                          const lt_epilogue *e, lt_real *y, void *work)
{
    job j = { .t = tiles_of(p, r), .m = p->o, .k = p->c, .x = x, .packed = packed, .e = e, .y = y };

    run_rounds(&j, 1, work);
}

const conv_way conv_winograd = { packed_elements, pack, work_bytes, run };
