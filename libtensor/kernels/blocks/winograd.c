/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/blocks/winograd.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/blocks/conv.h"
#include "libtensor/kernels/blocks/places.h"
#include "libtensor/kernels/conv/winograd.h"
#include "libtensor/kernels/conv/winograd2.h"
#include "libtensor/kernels/gemm/product.h"

enum { MOST_PLACES = 36 };

typedef struct {
    const lt_conv2d_params *p;
    const lt_real *x;
    const lt_conv2d_around *around;
    lt_real *y;
    int side;
    int64_t k, m;                       /* blocks of x, of y */
    int64_t wide, high;                 /* tiles of a row; rows of tiles of all images */
    int64_t first, rows, most;          /* rows of tiles of this round, and of the largest */
    lt_places at;                       /* of this round */
    lt_real *in;                        /* at.in, to be written */
} blocks_job;

int lt_winograd_blocks_side(const lt_conv2d_params *p)
{
    if (p->c % LT_BLOCK || p->o % LT_BLOCK || p->c > LT_PLACES_SEGMENTS * LT_BLOCK)
        return 0;
    return lt_winograd2_suits(p) ? 2 : lt_winograd_suits(p) ? 4 : 0;
}

static blocks_job plan(const lt_conv2d_params *p)
{
    blocks_job j = { .p = p, .side = lt_winograd_blocks_side(p), .k = lt_blocks_of(p->c), .m = lt_blocks_of(p->o) };
    const int64_t across = j.side + 2;
    int64_t bytes;

    j.at = (lt_places){ .places = (int)(across * across), .segments = j.k, .o = p->o,
                        .window = lt_places_window(p->o, j.k) };
    j.wide = lt_ceil_div(p->w, j.side);
    j.high = lt_ceil_div(p->h, j.side) * p->n;
    bytes = j.at.places * (j.k + j.m) * j.wide * LT_BLOCK * (int64_t)sizeof(float);
    j.most = lt_tile_size(j.high, lt_max_i64(1, lt_min_i64(j.high, LT_PLACES_BYTES / bytes)), 1);
    j.at.in_place = j.k * j.most * j.wide * LT_BLOCK + LT_PLACES_APART;
    j.at.out_place = j.m * j.most * j.wide * LT_BLOCK + LT_PLACES_APART;
    return j;
}

/* ---- windows: [place][panel of nr][channel][nr] ---- */

typedef struct { const lt_conv2d_params *p; const lt_real *weights; lt_real *packed; } window_job;

static void pack_panel(void *ctx, int64_t panel)
{
    const window_job *j = ctx;
    const int64_t nr = lt_k->nr, c = j->p->c, o = panel * nr, place = lt_places_window(j->p->o, lt_blocks_of(c));
    const lt_windows g = { j->weights + o * c * 9, c * 9, 9, false };

    lt_k->wino_windows(j->packed + o * c, place, nr, &g, lt_min_i64(nr, j->p->o - o), c);
}

int64_t lt_winograd_blocks_packed(const lt_conv2d_params *p)
{
    const blocks_job j = plan(p);

    return j.at.places * j.at.window;
}

void lt_winograd_blocks_pack(const lt_conv2d_params *p, const lt_real *weights, lt_real *packed)
{
    window_job j = { p, weights, packed };

    if (lt_winograd_blocks_side(p) == 2)
        conv_winograd2.pack(p, CONV_FORWARD, weights, packed);
    else
        lt_parallel_for(lt_ceil_div(p->o, lt_k->nr), pack_panel, &j);
}

/* ---- maps ---- */

/* A row of tiles of one block */
static void transform_input(void *ctx, int64_t task)
{
    const blocks_job *j = ctx;
    const int64_t row = task / j->k, block = task % j->k, of_image = j->high / j->p->n;
    const int64_t image = (j->first + row) / of_image, ty = (j->first + row) % of_image;
    const lt_real *map = j->x + (image * j->k + block) * j->p->h * j->p->w * LT_BLOCK;
    lt_real *out = j->in + (block * j->at.tiles + row * j->wide) * LT_BLOCK;

    for (int64_t t = 0; t < j->wide; t++, out += LT_BLOCK) {
        const lt_real *d[MOST_PLACES];

        lt_winograd_look(d, map, j->p->h, j->p->w, ty * j->side - 1, t * j->side - 1, j->side + 2);
        (j->side == 4 ? lt_k->wino_block_input : lt_k->wino2_input)(out, j->at.in_place, d);
    }
}

static void transform_output(void *ctx, int64_t task)
{
    const blocks_job *j = ctx;
    const lt_conv2d_around *around = j->around;
    const int64_t row = task / j->m, block = task % j->m, of_image = j->high / j->p->n, h = j->p->h, w = j->p->w;
    const int64_t image = (j->first + row) / of_image, y0 = (j->first + row) % of_image * j->side;
    const int64_t at = ((image * j->m + block) * h + y0) * w * LT_BLOCK;
    const lt_real *sums = j->at.out + (block * j->at.tiles + row * j->wide) * LT_BLOCK;
    lt_real beside[LT_BLOCK];

    for (int64_t t = 0; t < j->wide; t++) {
        lt_real *to[16];

        for (int i = 0; i < j->side * j->side; i++) {
            const int64_t y = i / j->side, x = t * j->side + i % j->side;

            to[i] = y0 + y < h && x < w ? j->y + at + (y * w + x) * LT_BLOCK : beside;
        }
        if (j->side == 4)
            lt_k->wino_block_output(to, sums + t * LT_BLOCK, j->at.out_place);
        else
            lt_k->wino2_output(to, sums + t * LT_BLOCK, j->at.out_place, LT_BLOCK);
    }
    lt_k->finish_block(j->y + at, around->bias ? around->bias + block * LT_BLOCK : NULL,
                       around->residual ? around->residual + at : NULL, around->act, lt_min_i64(j->side, h - y0) * w);
}

size_t lt_winograd_blocks_work(const lt_conv2d_params *p)
{
    const blocks_job j = plan(p);

    return (size_t)(j.at.places * (j.at.in_place + j.at.out_place)) * sizeof(lt_real);
}

void lt_winograd_blocks_forward(const lt_conv2d_params *p, const lt_real *x, const lt_real *packed,
                                const lt_conv2d_around *around, lt_real *y, void *work)
{
    blocks_job j = plan(p);

    j.x = x, j.around = around, j.y = y;
    j.in = work;
    j.at.in = j.in, j.at.windows = packed, j.at.out = j.in + j.at.places * j.at.in_place;
    for (j.first = 0; j.first < j.high; j.first += j.most) {
        j.rows = lt_min_i64(j.most, j.high - j.first);
        j.at.tiles = j.rows * j.wide;
        lt_parallel_for(j.rows * j.k, transform_input, &j);
        lt_places_multiply(&j.at);
        lt_parallel_for(j.rows * j.m, transform_output, &j);
    }
}
