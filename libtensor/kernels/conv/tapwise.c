/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/conv/tapwise.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/internal.h"
#include "libtensor/kernels/conv/turned.h"
#include "libtensor/kernels/gemm/tiles.h"

#include <string.h>

enum {
    MOST_POSITIONS = 256,       /* of a map that is read */
    MOST_ELEMENTS = 5 << 16,    /* of what the taps make of an image: it stays in the cache, ... */
    MOST_BY_TILES = 5 << 17,    /* ... or is made so fast that reading it once more pays */
    CHANNELS = 64,              /* whose taps one task adds ... */
    SUMS = LT_TURNED_MOST,      /* ... and their sums */
};

/* From k maps of h x w to m maps of to_h x to_w. Place y, x of these meets tap t at row (y + dy) / stride_h, column
 * (x + dx) / stride_w, where that is a place of the others. Element (k, tap, m) of the weights is
 * w[k * row + tap + m * col]. */
typedef struct {
    int64_t k, m, h, w, to_h, to_w;
    bool tiles;                         /* the positions of all images are the rows of one product on AMX's tiles */
    int stride_h, stride_w;
    int64_t row, col;
    conv_taps taps;
} shape;

static void find_places(shape *s, const lt_conv2d_params *p, conv_direction d)
{
    const int sign = d == CONV_FORWARD ? 1 : -1;

    conv_window_taps(&s->taps, p);
    for (int i = 0; i < s->taps.n; i++) {
        s->taps.at[i].dy *= sign;
        s->taps.at[i].dx *= sign;
    }
}

static void shape_of(shape *s, const lt_conv2d_params *p, conv_direction d)
{
    const int64_t taps = (int64_t)p->kh * p->kw, out_h = lt_conv2d_out_h(p), out_w = lt_conv2d_out_w(p);

    if (d == CONV_FORWARD)
        *s = (shape){ .k = p->c, .m = p->o, .h = p->h, .w = p->w, .to_h = out_h, .to_w = out_w, .stride_h = 1,
                      .stride_w = 1, .row = taps, .col = p->c * taps };
    else
        *s = (shape){ .k = p->o, .m = p->c, .h = out_h, .w = out_w, .to_h = p->h, .to_w = p->w,
                      .stride_h = p->stride_h, .stride_w = p->stride_w, .row = p->c * taps, .col = taps };
    find_places(s, p, d);
    s->tiles = lt_gemm_tiles_suits(p->n * s->h * s->w, s->taps.n * s->m, s->k);
}

static bool strided(const lt_conv2d_params *p)
{
    return p->stride_h > 1 || p->stride_w > 1;
}

bool lt_tapwise_suits(const lt_conv2d_params *p, conv_direction d)
{
    enum { FEW = 16 };
    shape s;
    int64_t n;

    if (p->groups > 1 || p->kh * p->kw == 1 || p->c < FEW || p->o < FEW || conv_nothing(p))
        return false;
    shape_of(&s, p, d);
    n = s.h * s.w;
    if (n > MOST_POSITIONS || s.to_w > SUMS / CHANNELS)
        return false;
    if (n * s.taps.n * s.m > (s.tiles ? MOST_BY_TILES : MOST_ELEMENTS))
        return false;
    return strided(p) ? d == CONV_DATA : lt_turned_saves(n, s.m);
}

/* ---- weights: panels of (tap, m), each [k][nr], or as of lt_gemm_tiles ---- */

static int64_t packed_elements(const lt_conv2d_params *p, conv_direction d)
{
    shape s;

    shape_of(&s, p, d);
    return (s.tiles ? lt_gemm_tiles_packed : lt_product_packed_b)(s.taps.n * s.m, s.k);
}

typedef struct { const shape *s; const lt_real *weights; lt_real *packed; } pack_job;

/* Rows k0 to k0 + k of `width` columns from the first on, zeros where these end */
static void gather(const pack_job *j, lt_real *out, int64_t first, int64_t width, int64_t k0, int64_t k)
{
    const shape *s = j->s;
    const int64_t n = lt_min_i64(width, s->taps.n * s->m - first);
    int64_t at[LT_TURNED_LANES];

    for (int64_t i = 0; i < n; i++)
        at[i] = (first + i) / s->m + (first + i) % s->m * s->col;
    for (int64_t l = k0; l < k0 + k; l++, out += width)
        for (int64_t i = 0; i < width; i++)
            out[i] = i < n ? j->weights[l * s->row + at[i]] : 0;
}

static void pack_panel(void *ctx, int64_t panel)
{
    const pack_job *j = ctx;
    const int64_t from = panel * lt_k->nr;

    gather(j, j->packed + from * j->s->k, from, lt_k->nr, 0, j->s->k);
}

static void pack_tiles(void *ctx, int64_t panel)
{
    enum { SIDE = LT_TILES_SIDE };
    const pack_job *j = ctx;
    const int64_t k = j->s->k;
    lt_real *out = j->packed + panel * lt_gemm_tiles_packed(SIDE, k);
    _Alignas(LT_ALIGN) lt_real rows[SIDE * SIDE];

    for (int64_t k0 = 0; k0 < k; k0 += SIDE, out += LT_TILES_BLOCK) {
        const int64_t n = lt_min_i64(SIDE, k - k0);

        gather(j, rows, panel * SIDE, SIDE, k0, n);
        lt_k->tiles_right(out, 0, rows, SIDE, n, SIDE);
    }
}

static void pack(const lt_conv2d_params *p, conv_direction d, const lt_real *weights, lt_real *packed)
{
    shape s;

    shape_of(&s, p, d);
    lt_parallel_for(lt_ceil_div(s.taps.n * s.m, s.tiles ? LT_TILES_SIDE : lt_k->nr), s.tiles ? pack_tiles : pack_panel,
                    &(pack_job){ &s, weights, packed });
}

/* ---- what the taps make of each position ---- */

typedef struct {
    const shape *s;
    const lt_real *x, *packed;
    const lt_conv2d_around *around;
    bool add;
    lt_real *y, *q, *turned;            /* turned: x by positions, for tiles */
    int64_t columns, ld;                /* (tap, m); between positions of q */
    int64_t rows, tiles, images;        /* positions of a tile; tiles of an image */
    int64_t channels, blocks;           /* whose taps one task adds; of all m */
    int64_t high, bands;                /* rows of such sums; of a map */
} tapwise_job;

/* Rows of q lie in different lines of the cache. */
static int64_t leading(const shape *s)
{
    enum { LANES = 16, ALIASED = 512 };
    const int64_t n = lt_ceil_div(s->taps.n * s->m, LANES) * LANES;

    return n % ALIASED ? n : n + LANES;
}

static size_t work_bytes(const lt_conv2d_params *p, conv_direction d)
{
    shape s;

    shape_of(&s, p, d);
    return (size_t)(p->n * s.h * s.w * (leading(&s) + (s.tiles ? s.k : 0))) * sizeof(lt_real);
}

/* The tiles of one panel follow each other. */
static void run_tile(void *ctx, int64_t task)
{
    const tapwise_job *j = ctx;
    const shape *s = j->s;
    const int64_t positions = s->h * s->w, image = task / j->tiles % j->images, from = task % j->tiles * j->rows;
    const int64_t at = task / j->tiles / j->images * lt_k->nr;

    lt_turned_product(j->q + (image * positions + from) * j->ld + at, j->ld, j->x + image * s->k * positions + from,
                      positions, j->packed + at * s->k, lt_min_i64(j->rows, positions - from),
                      lt_min_i64(lt_k->nr, j->columns - at), s->k, NULL);
}

static void turn_channels(void *ctx, int64_t task)
{
    const tapwise_job *j = ctx;
    const shape *s = j->s;
    const int64_t positions = s->h * s->w, image = task % j->images, from = task / j->images * CHANNELS;

    lt_k->turn(j->turned + image * positions * s->k + from, s->k, j->x + (image * s->k + from) * positions, positions,
               lt_min_i64(CHANNELS, s->k - from), positions, false);
}

static void multiply(tapwise_job *j)
{
    const shape *s = j->s;
    const int64_t positions = s->h * s->w, panels = lt_ceil_div(j->columns, lt_k->nr);

    if (s->tiles) {
        lt_parallel_for(lt_ceil_div(s->k, CHANNELS) * j->images, turn_channels, j);
        lt_gemm_tiles(j->images * positions, j->columns, s->k, j->turned, s->k, j->packed, false, j->q, j->ld, NULL);
        return;
    }
    j->rows = lt_turned_rows(positions, panels * j->images);
    j->tiles = lt_ceil_div(positions, j->rows);
    lt_parallel_for(panels * j->tiles * j->images, run_tile, j);
}

/* ---- and their sums ---- */

/* Tap t at row `row` of the result: n channels from m0 on of every column that meets it */
static void add_tap(const tapwise_job *j, lt_real *sums, int64_t image, int64_t row, int t, int64_t m0, int64_t n)
{
    const shape *s = j->s;
    const int64_t y = row + s->taps.at[t].dy, dx = s->taps.at[t].dx, step = s->stride_w;
    const int64_t from = dx > 0 ? lt_ceil_div(dx, step) : 0;
    const int64_t to = s->to_w + dx > 0 ? lt_min_i64(s->w, lt_ceil_div(s->to_w + dx, step)) : 0;
    const int64_t at = (image * s->h + y / s->stride_h) * s->w + from;

    if (y >= 0 && y % s->stride_h == 0 && y / s->stride_h < s->h && from < to)
        lt_k->add_lines(sums + (from * step - dx) * n, step * n, j->q + at * j->ld + t * s->m + m0, j->ld, to - from,
                        n);
}

static void run_sums(void *ctx, int64_t task)
{
    const tapwise_job *j = ctx;
    const shape *s = j->s;
    const lt_conv2d_around *around = j->around;
    const int64_t m0 = task % j->blocks * j->channels, n = lt_min_i64(j->channels, s->m - m0);
    const int64_t row = task / j->blocks % j->bands * j->high, high = lt_min_i64(j->high, s->to_h - row);
    const int64_t image = task / j->blocks / j->bands, out = s->to_h * s->to_w, places = high * s->to_w;
    const int64_t at = (image * s->m + m0) * out + row * s->to_w;
    const lt_epilogue e = { .col_bias = around->bias ? around->bias + m0 : NULL,
                            .act = around->residual ? (lt_act){ LT_ACT_NONE, 0 } : around->act };
    _Alignas(LT_ALIGN) lt_real sums[SUMS];

    memset(sums, 0, (size_t)(places * n) * sizeof(lt_real));
    for (int64_t r = 0; r < high; r++)
        for (int t = 0; t < s->taps.n; t++)
            add_tap(j, sums + r * s->to_w * n, image, row + r, t, m0, n);
    if (j->add) {                       /* the residual is y */
        lt_k->turn(j->y + at, out, sums, n, places, n, true);
        return;
    }
    lt_k->epilogue(sums, n, places, n, &e);
    lt_turned_place(j->y + at, out, around->residual ? around->residual + at : NULL, around->act, sums, n, places, n);
}

static void run(const lt_conv2d_params *p, conv_direction d, const lt_real *x, const lt_real *packed,
                const lt_conv2d_around *around, lt_real *y, void *work)
{
    shape s;
    tapwise_job j = {
        .s = &s, .x = x, .packed = packed, .around = around, .add = d == CONV_DATA && around->residual, .y = y,
        .q = work,
    };

    shape_of(&s, p, d);
    j.columns = s.taps.n * s.m;
    j.ld = leading(&s);
    j.images = p->n;
    j.turned = j.q + p->n * s.h * s.w * j.ld;
    multiply(&j);
    j.channels = lt_tile_size(s.m, CHANNELS, 16);
    j.blocks = lt_ceil_div(s.m, j.channels);
    j.high = lt_tile_size(s.to_h, lt_max_i64(1, SUMS / (s.to_w * lt_min_i64(s.m, j.channels))), 1);
    j.bands = lt_ceil_div(s.to_h, j.high);
    lt_parallel_for(j.blocks * j.bands * p->n, run_sums, &j);
}

const conv_way conv_tapwise = { packed_elements, pack, work_bytes, run };
