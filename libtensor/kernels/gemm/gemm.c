/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/gemm/gemm.h"

#include "libtensor/base/parallel.h"
#include "libtensor/kernels/gemm/product.h"

/* Rows that lie such a multiple apart share one set of the cache, which does not hold a panel's. */
enum { ALIASED = 1024 };

/* Operand i of a batch, element (row, col): base[i * step + row * row_step + col * col_step] */
typedef struct { const lt_real *base; int64_t row, col, step; } operand;

typedef struct {
    operand a, b;
    lt_product product;
    int64_t m, n, batch;                /* sizes of the whole */
    int64_t tile_m, tile_n;
    int64_t tiles_m, tiles_n;
    int64_t images;                     /* products of the batch that one task does */
    bool shared_a;                      /* so that one packing of A serves them all */
} job;

typedef struct { const job *j; const lt_real *a; } task_ctx;

static void pack_a(const void *ctx, lt_real *out, const lt_tile *t, int64_t k0, int64_t k)
{
    const task_ctx *c = ctx;
    const operand *a = &c->j->a;

    lt_k->pack_a(out, c->a + t->m0 * a->row + k0 * a->col, a->row, a->col, t->m, k);
}

static void pack_b(const void *ctx, lt_real *out, const lt_tile *t, int64_t image, int64_t k0, int64_t k)
{
    const operand *b = &((const task_ctx *)ctx)->j->b;
    const lt_real *at = b->base + image * b->step + k0 * b->row + t->n0 * b->col;

    lt_k->pack_b(out, at, b->row, b->col, k, t->n);
}

/* Tiles of the same rows follow each other, so a thread has rows of its own, which it often wrote itself. */
static void run_tile(void *ctx, int64_t task)
{
    const job *j = ctx;
    const int64_t tn = task % j->tiles_n, tm = task / j->tiles_n % j->tiles_m;
    const int64_t from = task / j->tiles_m / j->tiles_n * j->images;
    const int64_t to = lt_min_i64(j->batch, from + j->images);
    const lt_tile t = {
        tm * j->tile_m, lt_min_i64(j->tile_m, j->m - tm * j->tile_m),
        tn * j->tile_n, lt_min_i64(j->tile_n, j->n - tn * j->tile_n),
    };
    lt_product p = j->product;

    p.c += t.m0 * p.ldc + t.n0;
    for (int64_t i = from; i < to; i = j->shared_a ? to : i + 1) {
        const task_ctx c = { j, j->a.base + i * j->a.step };

        p.ctx = &c;
        lt_product_tile(&p, &t, i, j->shared_a ? to : i + 1);
    }
}

/* Tiles: large enough that packing is cheap, small enough that there are some eight of them, and an even number. */
static void cut(job *j)
{
    const int64_t work = j->m * j->n;
    const bool large = work * j->batch >= 8 * LT_TILE_M * 256;
    const int64_t fewest = lt_ceil_div(j->m, large ? LT_TILE_M : LT_FEW_ROWS);

    j->tile_n = j->product.b ? lt_product_columns(j->m, j->n) : lt_tile_size(j->n, LT_TILE_N, LT_PANELS);
    j->tiles_n = lt_ceil_div(j->n, j->tile_n);
    j->tile_m = lt_ceil_div(j->m, fewest + (fewest > 1 ? fewest * j->tiles_n % 2 : 0));
    j->tiles_m = lt_ceil_div(j->m, j->tile_m);
    j->images = lt_max_i64(1, lt_min_i64(j->batch, LT_TILE_N * 128 / lt_max_i64(1, work)));
}

static void run(job *j)
{
    if (j->m <= 0 || j->n <= 0 || j->batch <= 0)
        return;
    cut(j);
    const int64_t tasks = j->tiles_m * j->tiles_n * lt_ceil_div(j->batch, j->images);

    if ((double)j->m * (double)j->n * (double)j->product.k * (double)j->batch >= 25000) {
        lt_parallel_for(tasks, run_tile, j);
        return;
    }
    for (int64_t i = 0; i < tasks; i++)
        run_tile(j, i);
}

void lt_gemm_batch(int64_t count, lt_trans ta, lt_trans tb, int64_t m, int64_t n, int64_t k,
                   const lt_real *a, int64_t lda, int64_t a_step,
                   const lt_real *b, int64_t ldb, int64_t b_step,
                   bool add, lt_real *c, int64_t ldc, int64_t c_step, const lt_epilogue *e)
{
    job j = {
        .a = { a, ta ? 1 : lda, ta ? lda : 1, a_step },
        .b = { b, tb ? 1 : ldb, tb ? ldb : 1, b_step },
        .product = {
            .k = k, .pack_a = pack_a, .pack_b = pack_b, .c = c, .ldc = ldc, .c_step = c_step, .add = add,
            .e = e,
        },
        .m = m, .n = n, .batch = count, .shared_a = a_step == 0,
    };

    run(&j);
}

void lt_gemm(lt_trans ta, lt_trans tb, int64_t m, int64_t n, int64_t k, const lt_real *a, int64_t lda,
             const lt_real *b, int64_t ldb, bool add, lt_real *c, int64_t ldc, const lt_epilogue *e)
{
    lt_gemm_batch(1, ta, tb, m, n, k, a, lda, 0, b, ldb, 0, add, c, ldc, 0, e);
}

int64_t lt_gemm_packed_count(int64_t n, int64_t k)
{
    return lt_product_packed_b(n, k);
}

void lt_gemm_pack(lt_trans tb, int64_t n, int64_t k, const lt_real *b, int64_t ldb, lt_real *packed)
{
    const job j = { .b = { b, tb ? 1 : ldb, tb ? ldb : 1, 0 } };
    const task_ctx c = { &j, NULL };
    const lt_product p = { .k = k, .ctx = &c, .pack_b = pack_b };

    if (n > 0)
        lt_product_pack_b(&p, 1, n, LT_TILE_N, packed);
}

void lt_gemm_packed(lt_trans ta, int64_t m, int64_t n, int64_t k, const lt_real *a, int64_t lda,
                    const lt_real *packed, bool add, lt_real *c, int64_t ldc, const lt_epilogue *e)
{
    job j = {
        .a = { a, ta ? 1 : lda, ta ? lda : 1, 0 },
        .product = { .k = k, .b = packed, .b_columns = n, .pack_a = pack_a, .c = c, .ldc = ldc, .add = add, .e = e },
        .m = m, .n = n, .batch = 1,
    };

    if (!ta && lda % ALIASED) {
        j.product.rows = a;
        j.product.ld_rows = lda;
    }
    run(&j);
}

/* ---- a product of a product ---- */

enum {
    PAIR_ROWS = 56,             /* four tiles of 14: the weights' way into the cache is worth it */
    LINE = LT_ALIGN / (int)sizeof(lt_real),     /* between rows of the middle, or all of them would fall into one set */
};

typedef struct {
    const lt_real *a;
    lt_real *c;
    int64_t m, rows;                    /* of all, of a task */
    int64_t k, hidden, n;
    const lt_real *packed1, *packed2;
    const lt_epilogue *e1, *e2;
} pair_job;

typedef struct { const pair_job *j; int64_t task; } pair_task;

static void all_columns(lt_product *p, int64_t m, int64_t n)
{
    lt_real *c = p->c;
    lt_tile t = { .m = m };

    for (; t.n0 < n; t.n0 += t.n) {
        t.n = lt_min_i64(lt_tile_size(n, LT_TILE_N, LT_PANELS), n - t.n0);
        p->c = c + t.n0;
        lt_product_tile(p, &t, 0, 1);
    }
}

static void run_pair(void *ctx, lt_real *middle, lt_real *unused)
{
    const pair_task *t = ctx;
    const pair_job *j = t->j;
    const int64_t from = t->task * j->rows, m = lt_min_i64(j->rows, j->m - from), row = j->hidden + LINE;
    lt_epilogue e2 = *j->e2;
    lt_product first = { .k = j->k, .rows = j->a + from * j->k, .ld_rows = j->k, .b = j->packed1,
                         .b_columns = j->hidden, .c = middle, .ldc = row, .e = j->e1 };
    lt_product second = { .k = j->hidden, .rows = middle, .ld_rows = row, .b = j->packed2,
                          .b_columns = j->n, .c = j->c + from * j->n, .ldc = j->n, .e = &e2 };

    (void)unused;
    e2.residual = e2.residual ? e2.residual + from * e2.ld_residual : NULL;
    all_columns(&first, m, j->hidden);
    all_columns(&second, m, j->n);
}

static void some_rows(void *ctx, int64_t task)
{
    pair_task t = { ctx, task };

    lt_with_scratch(run_pair, &t);
}

bool lt_gemm_pair_suits(int64_t m, int64_t hidden, int64_t k)
{
    return m >= 4 * PAIR_ROWS && (hidden + LINE) * PAIR_ROWS <= LT_SCRATCH_A && k % ALIASED;
}

void lt_gemm_pair(int64_t m, int64_t k, const lt_real *a, int64_t hidden, const lt_real *packed1,
                  const lt_epilogue *e1, int64_t n, const lt_real *packed2, const lt_epilogue *e2, lt_real *c)
{
    pair_job j = { a, c, m, lt_tile_size(m, PAIR_ROWS, 1), k, hidden, n, packed1, packed2, e1, e2 };

    lt_parallel_for(lt_ceil_div(m, j.rows), some_rows, &j);
}
