/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Products on AMX's tiles whose operands are packed by the caller's functions. A tile's columns are done a strip at a
 * time, the strips of small images together: sums grow in the scratch, and go to C at the end.
 *
 * Packed A: for each tile of rows, for each segment of k, rows up to a multiple of LT_TILES_SIDE. Packed B: panels of
 * LT_TILES_SIDE columns.
 */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/gemm/product.h"

#include <string.h>

enum {
    SIDE = LT_TILES_SIDE,
    MOST_M = LT_PRODUCT_TILES_M,
    COLUMNS = LT_PRODUCT_TILES_N,
    FEW_SEGMENTS = LT_SCRATCH_A / (MOST_M * LT_TILES_ROW),      /* at a time, where both sides are packed for them; */
    SEGMENTS = 8,                                               /* where one of the two is, */
    APART = LT_BLOCK,                                           /* or all sums would fall into few sets of the cache */
    MADE = MOST_M * (COLUMNS + APART),
    RIGHT = COLUMNS / SIDE * LT_TILES_BLOCK,                    /* for each segment */
    ROOM = SIDE * LT_PRODUCT_ROOM,                              /* likewise, for rows of B on their way */
};
_Static_assert(MADE + FEW_SEGMENTS * (RIGHT + ROOM) <= LT_SCRATCH_B, "sums and the right side fit into scratch");
_Static_assert(MADE + SEGMENTS * ROOM <= LT_SCRATCH_B && SEGMENTS * RIGHT <= LT_SCRATCH_A, "alone it finds more");

static int64_t sides_of(int64_t n)
{
    return lt_ceil_div(n, SIDE);
}

/* ---- packing ------------------------------------------------------------------------------------------- */

int64_t lt_product_tiles_a(int64_t m, int64_t k)
{
    return sides_of(m) * sides_of(k) * LT_TILES_BLOCK;
}

int64_t lt_product_tiles_b(int64_t n, int64_t k)
{
    return sides_of(n) * sides_of(k) * LT_TILES_BLOCK;
}

typedef struct { const lt_product *p; int64_t count, size; lt_real *out; } pack_job;

/* One segment of the rows of one tile */
static void pack_rows(void *ctx, int64_t task)
{
    const pack_job *j = ctx;
    const int64_t k = j->p->k, sides = sides_of(k), k0 = task % sides * SIDE, from = task / sides * j->size;
    const lt_tile t = { .m0 = from, .m = lt_min_i64(j->size, j->count - from) };

    j->p->left(j->p->ctx, j->out + (from * sides + sides_of(t.m) * k0) * LT_TILES_ROW, 0, &t, k0,
               lt_min_i64(SIDE, k - k0));
}

void lt_product_tiles_pack_a(const lt_product *p, int64_t m, int64_t tile_m, lt_real *out)
{
    pack_job j = { p, m, tile_m, out };

    lt_parallel_for(lt_ceil_div(m, tile_m) * sides_of(p->k), pack_rows, &j);
}

/* Terms k0 to k0 + k of the columns of t */
static void pack_columns(const lt_product *p, lt_real *out, int64_t panel, lt_real *room, int64_t image,
                         const lt_tile *t, int64_t k0, int64_t k)
{
    int64_t ld = LT_PRODUCT_ROOM;
    const lt_real *rows = p->right(p->ctx, room, &ld, t, image, k0, k);

    lt_k->tiles_right(out, panel, rows, ld, k, t->n);
}

/* All terms of a strip of one image */
static void pack_strip(void *ctx, int64_t task)
{
    const pack_job *j = ctx;
    const int64_t strips = lt_ceil_div(j->count, j->size), image = task / strips, n0 = task % strips * j->size;
    const int64_t k = j->p->k, panel = sides_of(k) * LT_TILES_BLOCK;
    const lt_tile t = { .n0 = n0, .n = lt_min_i64(j->size, j->count - n0) };
    _Alignas(LT_ALIGN) lt_real room[SEGMENTS * ROOM];
    lt_real *out = j->out + (image * sides_of(j->count) + n0 / SIDE) * panel;

    for (int64_t k0 = 0; k0 < k; k0 += SEGMENTS * SIDE)
        pack_columns(j->p, out + k0 / SIDE * LT_TILES_BLOCK, panel, room, image, &t, k0,
                     lt_min_i64(SEGMENTS * SIDE, k - k0));
}

void lt_product_tiles_pack_b(const lt_product *p, int64_t images, int64_t n, lt_real *out)
{
    pack_job j = { p, n, COLUMNS, out };

    lt_parallel_for(images * lt_ceil_div(n, COLUMNS), pack_strip, &j);
}

/* ---- a tile -------------------------------------------------------------------------------------------- */

typedef struct { const lt_product *p; const lt_tile *t; int64_t from, to; } tile_call;

/* Some columns of a tile in some images: these follow each other, each from a panel of its own on */
typedef struct {
    const lt_product *p;
    lt_tile t;
    int64_t image, images, panels, made_row;    /* panels: of an image */
    lt_real *left, *right, *room, *made;
} strip;

static void multiply(const strip *s, int64_t first, int64_t segments)
{
    const lt_product *p = s->p;
    const int64_t sides = sides_of(p->k), rows = sides_of(s->t.m) * SIDE, k0 = first * SIDE;
    const int64_t k = lt_min_i64(segments * SIDE, p->k - k0);
    int64_t segment[SEGMENTS];
    lt_tiles g = {
        .a = p->a ? p->a + (s->t.m0 * sides + rows * first) * LT_TILES_ROW : s->left, .rows = s->t.m, .lines = 1,
        .segment = segment, .segments = segments, .b = s->right, .b_panel = segments * LT_TILES_BLOCK,
        .n = s->images * s->panels * SIDE, .c = s->made, .c_row = s->made_row, .plane = LT_BLOCK, .add = first > 0,
    };

    for (int64_t i = 0; i < segments; i++)
        segment[i] = i * rows * LT_TILES_ROW;
    if (!p->a)
        p->left(p->ctx, s->left, rows * LT_TILES_ROW, &s->t, k0, k);
    for (int64_t i = 0; !p->b && i < s->images; i++)
        pack_columns(p, s->right + i * s->panels * g.b_panel, g.b_panel, s->room, s->image + i, &s->t, k0, k);
    if (p->b) {
        g.b = p->b + s->image * p->b_step + (s->t.n0 / SIDE * sides + first) * LT_TILES_BLOCK;
        g.b_panel = sides * LT_TILES_BLOCK;
    }
    lt_k->gemm_tiles(&g);
}

/* An image's sums to C, at c, and what follows */
static void finish(const strip *s, int64_t image, lt_real *made, lt_real *c)
{
    enum { LINE = LT_ALIGN / (int)sizeof(lt_real), AHEAD = 4 };
    const lt_product *p = s->p;
    const int64_t n = s->t.n;

    for (int64_t i = 0; i < s->t.m; i++, made += s->made_row, c += p->ldc) {
        for (int64_t j = 0; j < n; j += LINE)
            __builtin_prefetch(c + AHEAD * p->ldc + j, 1);
        if (p->add)
            lt_k->add_to(made, c, (size_t)n);
        if (p->e) {
            const lt_tile row = { s->t.m0 + i, 1, s->t.n0, n };
            const lt_epilogue e = lt_product_epilogue(p, &row, image);

            lt_k->epilogue(made, n, 1, n, &e);
        }
        memcpy(c, made, (size_t)n * sizeof(*c));
    }
}

static void run_strip(const strip *s, lt_real *c)
{
    const int64_t sides = sides_of(s->p->k), blocks = lt_ceil_div(sides, s->p->a ? SEGMENTS : FEW_SEGMENTS);

    for (int64_t i = 0; i < blocks; i++)
        multiply(s, i * sides / blocks, (i + 1) * sides / blocks - i * sides / blocks);
    for (int64_t i = 0; i < s->images; i++)
        finish(s, s->image + i, s->made + i * s->panels * SIDE, c + (s->image + i) * s->p->c_step);
}

/* Of a strip: what the sums have room for, in all of the scratch where nothing is packed there */
static int64_t most_columns(const tile_call *c)
{
    const int64_t rows = sides_of(c->t->m) * SIDE;

    return c->p->a && c->p->b ? lt_min_i64(2 * COLUMNS, (LT_SCRATCH_B / rows - APART) / SIDE * SIDE) : COLUMNS;
}

static void run_tile(void *ctx, lt_real *a, lt_real *b)
{
    const tile_call *c = ctx;
    const lt_tile *t = c->t;
    const bool packed = c->p->a;
    const int64_t most = most_columns(c), together = lt_max_i64(1, most / (sides_of(t->n) * SIDE));

    for (int64_t image = c->from; image < c->to; image += together)
        for (int64_t j = 0; j < t->n; j += most) {
            strip s = { .p = c->p, .t = { t->m0, t->m, t->n0 + j, lt_min_i64(most, t->n - j) }, .image = image,
                        .images = lt_min_i64(together, c->to - image), .made_row = most + APART, .made = b, .left = a,
                        .room = b + MADE, .right = packed ? a : b + MADE + FEW_SEGMENTS * ROOM };

            s.panels = sides_of(s.t.n);
            run_strip(&s, c->p->c + j);
        }
}

void lt_product_tiles_tile(const lt_product *p, const lt_tile *t, int64_t from, int64_t to)
{
    lt_with_scratch(run_tile, &(tile_call){ p, t, from, to });
}
