/* SPDX-License-Identifier: Apache-2.0 */
/* hash_grid: features of a place from grids of many resolutions, whose corners share a table a grid.
 *                                                                                  [Mueller et al. 2022, section 3]
 *   x (..., 3) in [0, 1]   table (entries, F)   ->   y (..., levels F), level by level
 *   y of a level = sum over the cell's 8 corners of the trilinear weight times the corner's entry
 *   dtable[entry of corner] += weight dy        by level, in the order of points; x is a constant
 *
 * Level l has scale = base (finest / base)^(l / (levels - 1)) - 1 and resolution ceil(scale) + 1; x scale + 0.5 is cell
 * and fraction. Its corners count x first, then y, then z, where all of them, rounded up to a multiple of 8, are no
 * more than 2^log2_size entries; else they are hashed.
 */
#include "libtensor/ops/common.h"

enum { X, TABLE };
enum { BLOCK = 64, CORNERS = 8 };   /* points at a time */

/* The level's grid; *entries: how many it has */
static lt_hash_level level_of(const lt_hash_grid_opts *o, int level, int64_t *entries)
{
    const double growth = o->levels > 1 ? log2((double)o->finest / o->base) / (o->levels - 1) : 0;
    const double scale = exp2(level * growth) * o->base - 1;
    const int64_t side = (int64_t)ceil(scale) + 1, all = lt_ceil_div(side * side * side, 8) * 8;
    const bool hashed = all > (int64_t)1 << o->log2_size;

    *entries = hashed ? (int64_t)1 << o->log2_size : all;
    return (lt_hash_level){ .scale = (lt_real)scale, .side = (uint32_t)side, .entries = (uint32_t)*entries,
                            .hashed = hashed };
}

int64_t lt_hash_grid_entries(const lt_hash_grid_opts *o)
{
    int64_t sum = 0, entries;

    for (int i = 0; i < o->levels; i++) {
        level_of(o, i, &entries);
        sum += entries;
    }
    return sum;
}

static lt_status infer(lt_call *c)
{
    const lt_hash_grid_opts *o = c->attr;
    const lt_tensor *x = c->in[X];
    char text[LT_SHAPE_TEXT];

    if (x->shape.rank < 1 || lt_dim(x, -1) != 3)
        return lt_fail(c, "places are %s, want (..., 3)", lt_shape_text(&x->shape, text));
    if (o->levels < 1 || o->base < 2 || o->finest < o->base || o->finest > 1 << 20 || o->log2_size < 4
        || o->log2_size > 24)
        return lt_fail(c, "%d levels from %d to %d, tables of 2^%d: want at least one level, "
                       "2 <= base <= finest <= 2^20, 4 <= log2_size <= 24", o->levels, o->base, o->finest,
                       o->log2_size);
    if (lt_want_rank(c, TABLE, "table", 2))
        return LT_ESHAPE;
    if (lt_dim(c->in[TABLE], 0) != lt_hash_grid_entries(o))
        return lt_fail(c, "the table has %lld entries, the grids have %lld", (long long)lt_dim(c->in[TABLE], 0),
                       (long long)lt_hash_grid_entries(o));
    c->out->shape = x->shape;
    c->out->shape.dim[x->shape.rank - 1] = o->levels * lt_dim(c->in[TABLE], 1);
    return LT_OK;
}

static int64_t points_of(const lt_call *c)
{
    return op_outer(c->in[X], c->in[X]->shape.rank - 1);
}

/* A level: its grid, where its entries begin in the table, and its part of a row of y */
typedef struct {
    lt_hash_level grid;
    int64_t first, F, ldy, column;
} part;

static part part_of(const lt_call *c, int level)
{
    const lt_hash_grid_opts *o = c->attr;
    part p = { .F = lt_dim(c->in[TABLE], 1), .ldy = lt_dim(c->out, -1) };
    int64_t entries;

    for (int i = 0; i < level; i++) {
        level_of(o, i, &entries);
        p.first += entries;
    }
    p.grid = level_of(o, level, &entries);
    p.column = level * p.F;
    return p;
}

/* The corners of a block of points */
typedef struct {
    int32_t at[CORNERS * BLOCK];
    lt_real weight[CORNERS * BLOCK];
} corners;

static lt_samples look(const lt_call *c, const part *p, int64_t block, corners *k)
{
    const int64_t n = lt_min_i64(BLOCK, points_of(c) - block * BLOCK);

    lt_k->hash_corners(k->at, k->weight, BLOCK, (const lt_real *)c->in[X]->data + 3 * block * BLOCK, &p->grid,
                       (size_t)n);
    return (lt_samples){
        .x = (const lt_real *)c->in[TABLE]->data + p->first * p->F, .ldx = p->F, .d = p->F, .rows = n, .taps = CORNERS,
        .stride = BLOCK, .at = k->at, .weight = k->weight,
    };
}

enum { RUN = 16 };                  /* blocks of a task: of one level, whose table stays in the cache */

static int64_t runs_of(const lt_call *c)
{
    return lt_ceil_div(lt_ceil_div(points_of(c), BLOCK), RUN);
}

static void forward_run(void *ctx, int64_t task)
{
    const lt_call *c = ctx;
    const part p = part_of(c, (int)(task / runs_of(c)));
    const int64_t first = task % runs_of(c) * RUN;
    corners k;

    for (int64_t block = first; block < first + RUN && block * BLOCK < points_of(c); block++) {
        const lt_samples s = look(c, &p, block, &k);

        lt_k->sample((lt_real *)c->out->data + block * BLOCK * p.ldy + p.column, p.ldy, &s);
    }
}

static void forward(const lt_call *c)
{
    lt_parallel_for(((const lt_hash_grid_opts *)c->attr)->levels * runs_of(c), forward_run, (void *)c);
}

static void backward_level(void *ctx, int64_t level)
{
    const lt_call *c = ctx;
    const part p = part_of(c, (int)level);
    lt_real *dtable = c->din[TABLE] + p.first * p.F;
    corners k;

    op_start(c, TABLE, p.first * p.F, p.grid.entries * p.F);
    for (int64_t block = 0; block * BLOCK < points_of(c); block++) {
        const lt_samples s = look(c, &p, block, &k);

        lt_k->sample_spread(dtable, c->dout + block * BLOCK * p.ldy + p.column, p.ldy, &s);
    }
}

static void backward(const lt_call *c)
{
    if (c->din[TABLE])
        lt_parallel_for(((const lt_hash_grid_opts *)c->attr)->levels, backward_level, (void *)c);
}

static int64_t macs(const lt_call *c)
{
    return lt_numel(c->out) * CORNERS;
}

static const lt_op hash_grid_op = {
    .name = "hash_grid", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(TABLE), .infer = infer,
    .forward = forward, .backward = backward, .macs = macs,
};

lt_tensor *(lt_hash_grid)(lt_tensor *x, lt_tensor *table, const lt_hash_grid_opts *opts)
{
    return lt_apply(&hash_grid_op, opts, sizeof(*opts), (lt_tensor *[]){ x, table }, 2);
}
