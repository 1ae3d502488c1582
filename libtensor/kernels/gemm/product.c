/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/gemm/product.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"

static void multiply_bytes(const lt_product *p, const lt_tile *t, lt_real *c, const lt_real *a, const lt_real *b,
                           int64_t k0, int64_t k, const lt_epilogue *e)
{
    const int64_t at = p->rows ? t->n0 : t->m0;
    const lt_bytes q = { p->bytes->start ? p->bytes->start + at : NULL, p->bytes->scale + at };

    if (p->rows)
        lt_k->gemm_bytes_plain(c, p->ldc, p->rows + t->m0 * p->ld_rows + k0, p->ld_rows, b, k * lt_k->nr, t->m, t->n, k,
                               k0 > 0, &q, e);
    else
        lt_k->gemm_bytes(c, p->ldc, a, b, k * lt_k->nr, t->m, t->n, k, k0 > 0, &q, e);
}

/* The tile of one image, for k of the rows from k0 on; a: packed, unless A stays as it is. */
static void multiply(const lt_product *p, const lt_tile *t, int64_t image, const lt_real *a,
                     const lt_real *b, int64_t k0, int64_t k)
{
    const bool last = k0 + k == p->k && p->e, add = p->add || k0 > 0;
    lt_real *c = p->c + image * p->c_step;
    lt_epilogue e;

    if (last)
        e = lt_product_epilogue(p, t, image);
    if (p->bytes)
        multiply_bytes(p, t, c, a, b, k0, k, last ? &e : NULL);
    else if (p->rows)
        lt_k->gemm_plain(c, p->ldc, p->rows + t->m0 * p->ld_rows + k0, p->ld_rows, b, k * lt_k->nr, t->m, t->n, k, add,
                         last ? &e : NULL);
    else
        lt_k->gemm_block(c, p->ldc, a, b, k * lt_k->nr, t->m, t->n, k, add, last ? &e : NULL);
}

/* One block of k, `columns` columns of B at a time. */
static void block(const lt_product *p, const lt_tile *t, int64_t image, const lt_real *a, lt_real *b,
                  int64_t k0, int64_t k, int64_t columns)
{
    for (int64_t j = 0; j < t->n; j += columns) {
        const lt_tile part = { t->m0, t->m, t->n0 + j, lt_min_i64(columns, t->n - j) };
        lt_product at = *p;

        at.c += j;
        p->pack_b(p->ctx, b, &part, image, k0, k);
        multiply(&at, &part, image, a, b, k0, k);
    }
}

static int64_t whole_panels(int64_t n)
{
    return lt_ceil_div(n, lt_k->nr) * lt_k->nr;
}

static void blocks(const lt_product *p, const lt_tile *t, int64_t from, int64_t to, lt_real *a,
                   lt_real *b, int64_t columns)
{
    const int64_t n = lt_product_blocks(p->k);

    for (int64_t i = 0; i < n; i++) {
        const int64_t k0 = i * p->k / n, k = (i + 1) * p->k / n - k0;

        if (!p->a && !p->rows)
            p->pack_a(p->ctx, a, t, k0, k);
        for (int64_t image = from; image < to; image++) {
            const lt_real *left = p->a ? p->a + t->m0 * p->k + k0 * t->m : a;

            if (p->b)
                multiply(p, t, image, left, p->b + image * p->b_step + k0 * whole_panels(p->b_columns) + t->n0 * k, k0,
                         k);
            else
                block(p, t, image, left, b, k0, k, columns);
        }
    }
}

typedef struct { const lt_product *p; const lt_tile *t; int64_t from, to; } tile_call;

/* How many columns of B its scratch holds: more than LT_TILE_N where k is small */
static int64_t columns_at_once(int64_t k)
{
    const int64_t n = LT_SCRATCH_B / lt_max_i64(1, lt_min_i64(k, LT_PACK_K));

    return n / lt_k->nr * lt_k->nr;
}

static void run_tile(void *ctx, lt_real *a, lt_real *b)
{
    const tile_call *c = ctx;

    blocks(c->p, c->t, c->from, c->to, a, b, columns_at_once(c->p->k));
}

void lt_product_tile(const lt_product *p, const lt_tile *t, int64_t from, int64_t to)
{
    if (p->left)
        lt_product_tiles_tile(p, t, from, to);
    else
        lt_with_scratch(run_tile, &(tile_call){ p, t, from, to });
}

/* One block of k of one tile; count: all rows or columns, of which a tile has `size`. */
typedef struct { const lt_product *p; int64_t count, size, tiles; lt_real *out; } pack_job;
typedef struct { int64_t from, count, k0, k; } piece;

static piece piece_of(const pack_job *j, int64_t task)
{
    const int64_t n = lt_product_blocks(j->p->k), i = task / j->tiles % n, from = task % j->tiles * j->size;
    const int64_t k0 = i * j->p->k / n, end = (i + 1) * j->p->k / n;

    return (piece){ from, lt_min_i64(j->size, j->count - from), k0, end - k0 };
}

static void run_pack_a(void *ctx, int64_t task)
{
    const pack_job *j = ctx;
    const piece at = piece_of(j, task);
    const lt_tile t = { .m0 = at.from, .m = at.count };

    j->p->pack_a(j->p->ctx, j->out + at.from * j->p->k + at.k0 * at.count, &t, at.k0, at.k);
}

static void run_pack_b(void *ctx, int64_t task)
{
    const pack_job *j = ctx;
    const piece at = piece_of(j, task);
    const int64_t image = task / j->tiles / lt_product_blocks(j->p->k);
    const lt_tile t = { .n0 = at.from, .n = at.count };
    lt_real *out = j->out + image * lt_product_packed_b(j->count, j->p->k);

    j->p->pack_b(j->p->ctx, out + at.k0 * whole_panels(j->count) + at.from * at.k, &t, image, at.k0, at.k);
}

static void pack_all(const lt_product *p, int64_t images, int64_t count, int64_t size, lt_real *out,
                     lt_task_fn run)
{
    pack_job j = { p, count, size, lt_ceil_div(count, size), out };

    lt_parallel_for(j.tiles * lt_product_blocks(p->k) * images, run, &j);
}

int64_t lt_product_packed_b(int64_t n, int64_t k)
{
    return whole_panels(n) * k;
}

void lt_product_pack_a(const lt_product *p, int64_t m, int64_t tile_m, lt_real *out)
{
    if (p->left)
        lt_product_tiles_pack_a(p, m, tile_m, out);
    else
        pack_all(p, 1, m, tile_m, out, run_pack_a);
}

void lt_product_pack_b(const lt_product *p, int64_t images, int64_t n, int64_t columns, lt_real *out)
{
    if (p->left)
        lt_product_tiles_pack_b(p, images, n, out);
    else
        pack_all(p, images, n, columns, out, run_pack_b);
}
