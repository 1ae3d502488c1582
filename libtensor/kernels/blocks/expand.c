/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/blocks/expand.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/blocks/depthwise.h"
#include "libtensor/kernels/conv/internal.h"
#include "libtensor/kernels/conv/turned.h"

#include <string.h>

enum {
    SEGMENTS = LT_PACK_K / LT_BLOCK,            /* blocks of x, at most */
    TASKS = 8,                                  /* at least, where maps have enough rows */
};

typedef struct {
    const lt_conv_blocks_step *first;
    depthwise_blocks d;
    const lt_real *x;
    int64_t segment[SEGMENTS];
    int64_t together, groups;           /* blocks of what lies between that a task makes; groups of so many */
    int64_t row, plane;                 /* elements of what lies between: of a row with its zeros, of a block */
} job;

static int64_t blocks_together(void)
{
    return lt_max_i64(1, lt_k->nr / LT_BLOCK);
}

/* Some TASKS of them, an even number: rows where bands meet are made twice, but a single task that is left over costs
 * more. */
static int64_t bands_of(const lt_conv2d_params *second, int64_t groups)
{
    const int64_t most = lt_conv2d_out_h(second) / (2 * second->kh), of_band = groups * second->n;
    const int64_t bands = lt_ceil_div(TASKS, of_band);

    return lt_min_i64(bands > 1 ? bands + of_band * bands % 2 : 1, most);
}

static job plan(const lt_conv2d_params *first, const lt_conv2d_params *second)
{
    const int64_t groups = lt_ceil_div(lt_blocks_of(second->c), blocks_together());
    job j = { .d = depthwise_blocks_cut(second, bands_of(second, groups)), .together = blocks_together(),
              .groups = groups };

    j.row = j.d.window.wide * LT_BLOCK;
    j.plane = j.d.room * j.row;
    for (int64_t s = 0; s < lt_blocks_of(first->c); s++)
        j.segment[s] = s * first->h * first->w * LT_BLOCK;
    return j;
}

bool lt_expand_blocks_suits(const lt_conv2d_params *first, const lt_conv2d_params *second)
{
    enum { NARROW = 12 };               /* rows of the map are rows of the product's tiles */
    const depthwise_blocks d = depthwise_blocks_cut(second, 1);

    return first->c <= LT_PACK_K && second->w >= NARROW
           && d.room * d.window.wide * blocks_together() * LT_BLOCK <= LT_SCRATCH_B;
}

/* ---- a task: a band of a group --------------------------------------------------------------------------------- */

typedef struct {
    const job *j;
    int64_t image, band, group;
    int64_t blocks;                     /* of the group */
    lt_real *between;                   /* [block][row][position][LT_BLOCK], */
    int64_t from, to;                   /* rows [from, to) of the map */
} expansion;

/* Rows up to `to` of one panel of channels, from o on */
static void make_panel(const expansion *t, int64_t o, int64_t to)
{
    const job *j = t->j;
    const lt_conv2d_params *p = j->first->p;
    const int64_t blocks = lt_blocks_of(p->c), line = p->w * LT_BLOCK, at = o - t->group * j->together * LT_BLOCK;
    lt_real bias[LT_TURNED_LANES];
    const lt_blocks g = {
        .a = j->x + (t->image * blocks * p->h + t->to) * line, .rows = p->w, .step = LT_BLOCK,
        .lines = to - t->to, .line = line, .segment = j->segment, .segments = blocks, .each = LT_BLOCK,
        .last = p->c - (blocks - 1) * LT_BLOCK, .b = j->first->packed + o * blocks * LT_BLOCK,
        .n = lt_min_i64(lt_k->nr, lt_blocks_of(p->o) * LT_BLOCK - o),
        .c = t->between + at / LT_BLOCK * j->plane + (t->to - t->from) * j->row + j->d.window.pad * LT_BLOCK
             + at % LT_BLOCK,
        .plane = j->plane, .c_line = j->row,
    };
    const lt_epilogue e = conv_panel_epilogue(p, &j->first->around, o, g.n, 0, bias);

    lt_k->gemm_blocks(&g, &e);
}

/* Rows [from, to) are there afterwards, and those before them forgotten. */
static void make_rows(expansion *t, int64_t from, int64_t to)
{
    const job *j = t->j;
    const int64_t o = t->group * j->together * LT_BLOCK;

    for (int64_t b = 0; t->to > from && b < t->blocks; b++)
        memmove(t->between + b * j->plane, t->between + b * j->plane + (from - t->from) * j->row,
                (size_t)((t->to - from) * j->row) * sizeof(lt_real));
    t->from = from, t->to = lt_max_i64(t->to, from);
    for (int64_t at = 0; t->to < to && at < t->blocks * LT_BLOCK; at += lt_k->nr)
        make_panel(t, o + at, to);
    t->to = lt_max_i64(t->to, to);
}

/* Zeros at the sides of all rows, which nothing overwrites */
static void clear_sides(const expansion *t)
{
    const int64_t side = t->j->d.window.pad * LT_BLOCK, row = t->j->row;

    for (int64_t i = 0; i < t->blocks * t->j->d.room; i++) {
        memset(t->between + i * row, 0, (size_t)side * sizeof(lt_real));
        memset(t->between + (i + 1) * row - side, 0, (size_t)side * sizeof(lt_real));
    }
}

static void run_band(void *ctx, lt_real *unused, lt_real *between)
{
    expansion *t = ctx;
    const job *j = t->j;
    const depthwise_blocks *d = &j->d;
    const int64_t end = lt_min_i64((t->band + 1) * d->band, d->out_h);

    (void)unused;
    t->between = between;
    clear_sides(t);
    for (int64_t row = t->band * d->band, to; row < end; row = to) {
        to = lt_min_i64(row + d->rows, end);
        make_rows(t, depthwise_blocks_first_row(d, row), depthwise_blocks_end_row(d, to - 1));
        for (int64_t b = 0; b < t->blocks; b++) {
            const depthwise_place at = { t->image, t->band, t->group * j->together + b };

            depthwise_blocks_rows(d, &at, between + b * j->plane, t->from, row, to);
        }
    }
}

static void run_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    expansion t = { .j = j, .image = task / j->groups / j->d.bands, .band = task / j->groups % j->d.bands,
                    .group = task % j->groups };

    t.blocks = lt_min_i64(j->together, j->d.blocks - t.group * j->together);
    lt_with_scratch(run_band, &t);
}

size_t lt_expand_blocks_work(const lt_conv2d_params *first, const lt_conv2d_params *second)
{
    const job j = plan(first, second);

    return depthwise_blocks_sums(&j.d);
}

void lt_expand_blocks_forward(const lt_conv_blocks_step *first, const lt_conv_blocks_step *second, const lt_real *x,
                              lt_real *y, void *work)
{
    job j = plan(first->p, second->p);

    j.first = first, j.x = x;
    j.d.packed = second->packed, j.d.around = &second->around, j.d.y = y, j.d.sums = work;
    lt_parallel_for(second->p->n * j.d.bands * j.groups, run_task, &j);
    depthwise_blocks_mean(&j.d);
}
