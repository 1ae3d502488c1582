/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/blocks/blocks.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/gemm/product.h"

#include <string.h>

enum { BANDS = 8 };                 /* of a map, about; fewer of a small one */

typedef struct { lt_real *y; const lt_real *x; int64_t c, positions, bands, band; } turn_job;

typedef struct { int64_t image, block, lanes, from, n; } turn_part;

static turn_part part_of(const turn_job *j, int64_t task)
{
    const int64_t blocks = lt_blocks_of(j->c), from = task / blocks % j->bands * j->band;

    return (turn_part){
        .image = task / blocks / j->bands, .block = task % blocks, .from = from,
        .lanes = lt_min_i64(LT_BLOCK, j->c - task % blocks * LT_BLOCK), .n = lt_min_i64(j->band, j->positions - from),
    };
}

static void from_maps(void *ctx, int64_t task)
{
    const turn_job *j = ctx;
    const turn_part t = part_of(j, task);
    lt_real *y = j->y + ((t.image * lt_blocks_of(j->c) + t.block) * j->positions + t.from) * LT_BLOCK;

    if (t.lanes < LT_BLOCK)
        memset(y, 0, (size_t)(t.n * LT_BLOCK) * sizeof(lt_real));
    lt_k->turn(y, LT_BLOCK, j->x + (t.image * j->c + t.block * LT_BLOCK) * j->positions + t.from, j->positions, t.lanes,
               t.n, false);
}

static void to_maps(void *ctx, int64_t task)
{
    const turn_job *j = ctx;
    const turn_part t = part_of(j, task);

    lt_k->turn(j->y + (t.image * j->c + t.block * LT_BLOCK) * j->positions + t.from, j->positions,
               j->x + ((t.image * lt_blocks_of(j->c) + t.block) * j->positions + t.from) * LT_BLOCK, LT_BLOCK, t.n,
               t.lanes, false);
}

static void turn_all(lt_real *y, const lt_real *x, int64_t n, int64_t c, int64_t positions, lt_task_fn run)
{
    const int64_t most = lt_max_i64(256, lt_ceil_div(positions, BANDS));
    turn_job j = { y, x, c, positions, 1, lt_tile_size(positions, most, LT_BLOCK) };

    j.bands = lt_ceil_div(positions, j.band);
    lt_parallel_for(n * j.bands * lt_blocks_of(c), run, &j);
}

void lt_blocks_from_maps(lt_real *y, const lt_real *x, int64_t n, int64_t c, int64_t positions)
{
    turn_all(y, x, n, c, positions, from_maps);
}

void lt_blocks_to_maps(lt_real *y, const lt_real *x, int64_t n, int64_t c, int64_t positions)
{
    turn_all(y, x, n, c, positions, to_maps);
}

typedef struct { lt_real *mean; const lt_real *x; int64_t c, positions; } mean_job;

static void mean_of_block(void *ctx, int64_t task)
{
    const mean_job *j = ctx;
    const int64_t blocks = lt_blocks_of(j->c), image = task / blocks, c = task % blocks * LT_BLOCK;
    double sum[LT_BLOCK] = { 0 };

    lt_k->sum_block(sum, j->x + task * j->positions * LT_BLOCK, j->positions);
    for (int64_t i = 0; i < lt_min_i64(LT_BLOCK, j->c - c); i++)
        j->mean[image * j->c + c + i] = (lt_real)(sum[i] / (double)j->positions);
}

void lt_blocks_mean(lt_real *mean, const lt_real *x, int64_t n, int64_t c, int64_t positions)
{
    mean_job j = { mean, x, c, positions };

    lt_parallel_for(n * lt_blocks_of(c), mean_of_block, &j);
}
