/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/conv/turned.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/conv/internal.h"
#include "libtensor/kernels/conv/way.h"

#include <string.h>

enum {
    MOST_ROWS = 98,             /* positions of a tile: seven panels of 14 */
    MAPS = 64,                  /* that one task multiplies with their gates */
};

static int64_t lanes(int64_t n, int64_t vector)
{
    return lt_ceil_div(n, vector) * vector;
}

/* By the vectors of AVX-512, whatever is in use: the choice shows in a profile. An eighth more lanes pay for the
 * way back. */
bool lt_turned_saves(int64_t n, int64_t m)
{
    return n * lanes(m, 16) * 8 <= m * lanes(n, 32) * 7;
}

bool lt_turned_suits(const lt_conv2d_params *p)
{
    return conv_pointwise(p) && p->groups == 1 && lt_turned_saves(p->h * p->w, p->o);
}

/* ---- weights: panels of channels, each [c][nr] ---- */

static int64_t packed_elements(const lt_conv2d_params *p, conv_direction d)
{
    (void)d;
    return lt_product_packed_b(p->o, p->c);
}

typedef struct { const lt_conv2d_params *p; const lt_real *weights; lt_real *packed; } pack_job;

static void pack_panel(void *ctx, int64_t panel)
{
    const pack_job *j = ctx;
    const int64_t c = j->p->c, from = panel * lt_k->nr;

    lt_k->pack_b(j->packed + from * c, j->weights + from * c, 1, c, c, lt_min_i64(lt_k->nr, j->p->o - from));
}

static void pack(const lt_conv2d_params *p, conv_direction d, const lt_real *weights, lt_real *packed)
{
    (void)d;
    lt_parallel_for(lt_ceil_div(p->o, lt_k->nr), pack_panel, &(pack_job){ p, weights, packed });
}

/* ---- forward ---- */

typedef struct {
    const lt_conv2d_params *p;
    const lt_real *x, *packed;
    const lt_conv2d_around *around;
    lt_real *y, *gated;
    bool few;                           /* channels: fewer weights than elements of x */
    int64_t positions, panels;
    int64_t rows, tiles;                /* positions of a tile; tiles of all images */
} turned_job;

static bool few_channels(const lt_conv2d_params *p)
{
    return p->o < p->h * p->w;
}

/* Gates are multiplied into what is less: the weights while they are in L1, or the maps before all of it. */
static size_t work_bytes(const lt_conv2d_params *p, conv_direction d)
{
    (void)d;
    return few_channels(p) ? 0 : (size_t)(p->n * p->c * p->h * p->w) * sizeof(lt_real);
}

static void gate_maps(void *ctx, int64_t part)
{
    const turned_job *j = ctx;
    const int64_t maps = j->p->n * j->p->c, n = j->positions;

    for (int64_t i = part * MAPS; i < lt_min_i64(maps, (part + 1) * MAPS); i++)
        lt_k->scale(j->gated + i * n, j->x + i * n, j->around->gate[i], (size_t)n);
}

int64_t lt_turned_rows(int64_t n, int64_t parts)
{
    enum { TASKS = 8 };

    return lt_tile_size(n, lt_max_i64(1, lt_min_i64(MOST_ROWS, lt_ceil_div(n, lt_ceil_div(TASKS, parts)))), 1);
}

static void product(lt_real *c, int64_t ldc, const lt_real *x, int64_t ldx, const lt_real *b, const lt_real *gate,
                    int64_t rows, int64_t n, int64_t k, const lt_epilogue *e)
{
    const int64_t blocks = lt_product_blocks(k);
    _Alignas(LT_ALIGN) lt_real gated[LT_PACK_K * LT_TURNED_LANES];

    for (int64_t i = 0; i < blocks; i++) {
        const int64_t k0 = i * k / blocks, end = (i + 1) * k / blocks;
        const lt_real *panel = b + k0 * lt_k->nr;

        if (gate) {
            lt_k->scale_panels(gated, panel, gate + k0, end - k0, n);
            panel = gated;
        }
        lt_k->gemm_columns(c, ldc, x + k0 * ldx, ldx, panel, rows, n, end - k0, i > 0, end == k ? e : NULL);
    }
}

void lt_turned_product(lt_real *c, int64_t ldc, const lt_real *x, int64_t ldx, const lt_real *b, int64_t rows,
                       int64_t n, int64_t k, const lt_epilogue *e)
{
    product(c, ldc, x, ldx, b, NULL, rows, n, k, e);
}

void lt_turned_place(lt_real *y, int64_t ld, const lt_real *residual, lt_act act, const lt_real *tile, int64_t ld_tile,
                     int64_t rows, int64_t n)
{
    const lt_epilogue e = { .residual = residual, .ld_residual = ld, .act = act };
    _Alignas(LT_ALIGN) lt_real turned[LT_TURNED_MOST];

    if (!residual) {
        lt_k->turn(y, ld, tile, ld_tile, rows, n, false);
        return;
    }
    lt_k->turn(turned, rows, tile, ld_tile, rows, n, false);
    lt_k->epilogue(turned, rows, n, rows, &e);
    for (int64_t i = 0; i < n; i++)
        memcpy(y + i * ld, turned + i * rows, (size_t)rows * sizeof(lt_real));
}

/* A thread's tasks follow each other: they share a panel, or with few channels a tile, whichever is more to fetch. */
static void run_tile(void *ctx, int64_t task)
{
    const turned_job *j = ctx;
    const lt_conv2d_params *p = j->p;
    const lt_conv2d_around *around = j->around;
    const int64_t tile = j->few ? task / j->panels : task % j->tiles;
    const int64_t panel = j->few ? task % j->panels : task / j->tiles;
    const int64_t per_image = j->tiles / p->n, image = tile / per_image;
    const int64_t from = tile % per_image * j->rows, rows = lt_min_i64(j->rows, j->positions - from);
    const int64_t o = panel * lt_k->nr, n = lt_min_i64(lt_k->nr, p->o - o);
    const lt_epilogue e = { .col_bias = around->bias ? around->bias + o : NULL,
                            .act = around->residual ? (lt_act){ LT_ACT_NONE, 0 } : around->act };
    const int64_t at = (image * p->o + o) * j->positions + from;
    _Alignas(LT_ALIGN) lt_real sums[MOST_ROWS * LT_TURNED_LANES];

    product(sums, lt_k->nr, j->x + image * p->c * j->positions + from, j->positions, j->packed + o * p->c,
            j->few && around->gate ? around->gate + image * p->c : NULL, rows, n, p->c, &e);
    lt_turned_place(j->y + at, j->positions, around->residual ? around->residual + at : NULL, around->act, sums,
                    lt_k->nr, rows, n);
}

static void run(const lt_conv2d_params *p, conv_direction d, const lt_real *x, const lt_real *packed,
                const lt_conv2d_around *around, lt_real *y, void *work)
{
    const int64_t positions = p->h * p->w, panels = lt_ceil_div(p->o, lt_k->nr);
    turned_job j = {
        .p = p, .x = x, .packed = packed, .around = around, .y = y, .gated = work, .few = few_channels(p),
        .positions = positions, .panels = panels, .rows = lt_turned_rows(positions, panels * p->n),
    };

    (void)d;
    j.tiles = lt_ceil_div(positions, j.rows) * p->n;
    if (around->gate && !j.few) {
        lt_parallel_for(lt_ceil_div(p->n * p->c, MAPS), gate_maps, &j);
        j.x = work;
    }
    lt_parallel_for(panels * j.tiles, run_tile, &j);
}

const conv_way conv_turned = { packed_elements, pack, work_bytes, run };
