/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/blocks/tall.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/blocks/blocks.h"
#include "libtensor/kernels/blocks/places.h"
#include "libtensor/kernels/conv/internal.h"
#include "libtensor/kernels/gemm/product.h"

#include <string.h>

enum { SIDE = 4, TAPS = 5, PLACES = SIDE + TAPS - 1, MOST_PARTS = 8 };

/* Up to TAPS taps of a window, from `first` on and a stride apart */
typedef struct { int n, first[MOST_PARTS]; } parts;

typedef struct {
    const lt_conv2d_params *p;
    const lt_real *x;
    const lt_conv2d_around *around;
    lt_real *y;
    parts parts;
    int64_t k, m;                       /* blocks of x, of y */
    int64_t out_h, of_image, high;      /* rows of y; rows of tiles of an image, of all */
    int64_t first, most;                /* rows of tiles: where this round begins, and of the largest round */
    lt_places at;
    lt_real *in;                        /* at.in, to be written */
} tall_job;

/* ---- shapes ---- */

static parts parts_of(const lt_conv2d_params *p)
{
    parts all = { 0 };

    for (int phase = 0; phase < p->stride_h; phase++)
        for (int tap = phase; tap < p->kh; tap += TAPS * p->stride_h)
            all.first[all.n++] = tap;
    return all;
}

/* Taps that see the map, of all places of a column of y */
static int64_t taps_inside(const lt_conv2d_params *p)
{
    int64_t n = 0;

    for (int64_t y = 0; y < lt_conv2d_out_h(p); y++)
        for (int tap = 0; tap < p->kh; tap++) {
            const int64_t row = y * p->stride_h - p->pad_h + tap;

            n += row >= 0 && row < p->h;
        }
    return n;
}

/* What surrounds the products is reckoned half as much as these. */
bool lt_tall_suits(const lt_conv2d_params *p)
{
    enum { FEW = 32, MOST_STRIDE = 2, MOST_TAPS = MOST_PARTS * TAPS };
    const bool column = p->kw == 1 && p->stride_w == 1 && !p->pad_w && p->dil_h == 1 && p->groups == 1;

    if (!column || p->stride_h > MOST_STRIDE || p->kh > MOST_TAPS || p->c % LT_BLOCK || p->o % LT_BLOCK || p->c < FEW
        || p->o < FEW || conv_nothing(p) || parts_of(p).n * lt_blocks_of(p->c) > LT_PLACES_SEGMENTS)
        return false;
    return 3 * PLACES * parts_of(p).n * lt_ceil_div(lt_conv2d_out_h(p), SIDE) < 2 * taps_inside(p);
}

static tall_job plan(const lt_conv2d_params *p)
{
    tall_job j = { .p = p, .parts = parts_of(p), .k = lt_blocks_of(p->c), .m = lt_blocks_of(p->o),
                   .out_h = lt_conv2d_out_h(p), .at = { .places = PLACES, .o = p->o } };
    int64_t bytes;

    j.of_image = lt_ceil_div(j.out_h, SIDE);
    j.high = j.of_image * p->n;
    j.at.segments = j.parts.n * j.k;
    bytes = PLACES * (j.at.segments + j.m) * p->w * LT_BLOCK * (int64_t)sizeof(lt_real);
    j.most = lt_tile_size(j.high, lt_max_i64(1, lt_min_i64(j.high, LT_PLACES_BYTES / bytes)), 1);
    j.at.in_place = j.at.segments * j.most * p->w * LT_BLOCK + LT_PLACES_APART;
    j.at.out_place = j.m * j.most * p->w * LT_BLOCK + LT_PLACES_APART;
    j.at.window = lt_places_window(p->o, j.at.segments);
    return j;
}

/* ---- windows ---- */

/* G g of the taps of a part, a stride apart in g */
static void transform_taps(double out[PLACES], const parts *all, int part, const lt_conv2d_params *p, const lt_real *g)
{
    static const double point[PLACES - 1] = { 0, 1, -1, 2, -2, 0.5, -0.5 };
    static const double scale[PLACES - 1] = { 1, -2 / 9.0, -2 / 9.0, 1 / 90.0, 1 / 90.0, 32 / 45.0, 32 / 45.0 };
    double tap[TAPS] = { 0 };

    for (int i = 0; i < TAPS && all->first[part] + i * p->stride_h < p->kh; i++)
        tap[i] = (double)g[all->first[part] + i * p->stride_h];
    for (int k = 0; k < PLACES - 1; k++) {
        out[k] = 0;
        for (int i = TAPS - 1; i >= 0; i--)
            out[k] = out[k] * point[k] + tap[i];
        out[k] *= scale[k];
    }
    out[PLACES - 1] = tap[TAPS - 1];
}

typedef struct { const tall_job *j; const lt_real *weights; lt_real *packed; } window_job;

static void pack_panel(void *ctx, int64_t panel)
{
    const window_job *w = ctx;
    const lt_conv2d_params *p = w->j->p;
    const int64_t nr = lt_k->nr, o = panel * nr, n = lt_min_i64(nr, p->o - o), k = w->j->at.segments * LT_BLOCK;
    lt_real *out = w->packed + o * k;

    for (int place = 0; place < PLACES; place++)
        memset(out + place * w->j->at.window, 0, (size_t)(k * nr) * sizeof(*out));
    for (int part = 0; part < w->j->parts.n; part++)
        for (int64_t c = 0; c < p->c; c++, out += nr)
            for (int64_t i = 0; i < n; i++) {
                double v[PLACES];

                transform_taps(v, &w->j->parts, part, p, w->weights + ((o + i) * p->c + c) * p->kh);
                for (int place = 0; place < PLACES; place++)
                    out[place * w->j->at.window + i] = (lt_real)v[place];
            }
}

int64_t lt_tall_packed(const lt_conv2d_params *p)
{
    return PLACES * plan(p).at.window;
}

void lt_tall_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    const tall_job j = plan(p);

    lt_parallel_for(lt_ceil_div(p->o, lt_k->nr), pack_panel, &(window_job){ &j, weights, packed });
}

/* ---- maps ---- */

/* Row `row` of this round's tiles: which rows of which image */
typedef struct { int64_t image, y; } tile_row;

static tile_row row_of(const tall_job *j, int64_t row)
{
    return (tile_row){ (j->first + row) / j->of_image, (j->first + row) % j->of_image * SIDE };
}

/* A row of tiles of one block, for each part of the window */
static void transform_input(void *ctx, int64_t task)
{
    const tall_job *j = ctx;
    const lt_conv2d_params *p = j->p;
    const int64_t row = task / j->k, block = task % j->k, line = p->w * LT_BLOCK;
    const tile_row at = row_of(j, row);
    const lt_real *map = j->x + (at.image * j->k + block) * p->h * line;

    for (int part = 0; part < j->parts.n; part++) {
        const int64_t top = at.y * p->stride_h - p->pad_h + j->parts.first[part];
        const lt_real *d[PLACES];

        for (int i = 0; i < PLACES; i++) {
            const int64_t y = top + i * p->stride_h;

            d[i] = y >= 0 && y < p->h ? map + y * line : NULL;
        }
        lt_k->tall_input(j->in + (part * j->k + block) * j->at.tiles * LT_BLOCK + row * line, j->at.in_place, d, p->w);
    }
}

static void transform_output(void *ctx, int64_t task)
{
    const tall_job *j = ctx;
    const lt_conv2d_around *around = j->around;
    const int64_t row = task / j->m, block = task % j->m, w = j->p->w, line = w * LT_BLOCK;
    const tile_row at = row_of(j, row);
    const int64_t from = ((at.image * j->m + block) * j->out_h + at.y) * line, rows = lt_min_i64(SIDE, j->out_h - at.y);
    lt_real *to[SIDE];

    for (int i = 0; i < SIDE; i++)
        to[i] = i < rows ? j->y + from + i * line : NULL;
    lt_k->tall_output(to, j->at.out + (block * j->at.tiles + row * w) * LT_BLOCK, j->at.out_place, w);
    lt_k->finish_block(j->y + from, around->bias ? around->bias + block * LT_BLOCK : NULL,
                       around->residual ? around->residual + from : NULL, around->act, rows * w);
}

size_t lt_tall_work(const lt_conv2d_params *p)
{
    const lt_places at = plan(p).at;

    return (size_t)(PLACES * (at.in_place + at.out_place)) * sizeof(lt_real);
}

void lt_tall_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed, const lt_conv2d_around *around,
                     lt_real *y, void *work)
{
    tall_job j = plan(p);

    j.x = x, j.around = around, j.y = y;
    j.in = work;
    j.at.in = j.in, j.at.windows = packed, j.at.out = j.in + PLACES * j.at.in_place;
    for (j.first = 0; j.first < j.high; j.first += j.most) {
        const int64_t rows = lt_min_i64(j.most, j.high - j.first);

        j.at.tiles = rows * p->w;
        lt_parallel_for(rows * j.k, transform_input, &j);
        lt_places_multiply(&j.at);
        lt_parallel_for(rows * j.m, transform_output, &j);
    }
}
