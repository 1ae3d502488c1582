/* SPDX-License-Identifier: Apache-2.0 */
/* A product with weights whose left side is read as 8-bit integers: rows of bytes times packed weights. */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/gemm/product.h"
#include "libtensor/kernels/int8/int8.h"
#include "libtensor/kernels/int8/weights.h"

/* Rows that lie such a multiple of words apart share one set of the cache; another line between them helps. */
enum { ALIASED = 1024, LINE = 16 };

static int64_t row_words(int64_t k)
{
    const int64_t words = int8_words(k);

    return words % ALIASED ? words : words + LINE;
}

bool lt_gemm_int8_suits(int64_t n, int64_t k)
{
    return sizeof(lt_real) == INT8_WORD && n > 0 && k >= INT8_LEAST_K && k <= INT8_MOST_K;
}

/* ---- weights: packed words, then the scale of each column, then what its sums start from ---------------- */

int64_t lt_gemm_int8_packed(int64_t n, int64_t k)
{
    return lt_product_packed_b(n, int8_words(k)) + 2 * n;
}

size_t lt_gemm_int8_pack_work(int64_t n, int64_t k)
{
    return (size_t)(n * int8_words(k)) * sizeof(lt_real);
}

typedef struct { const lt_real *words; int64_t k; } weights;

static void pack_weights(const void *ctx, lt_real *out, const lt_tile *t, int64_t image, int64_t k0, int64_t k)
{
    const weights *w = ctx;

    (void)image;
    lt_k->pack_b(out, w->words + t->n0 * w->k + k0, 1, w->k, k, t->n);
}

void lt_gemm_int8_pack(int64_t n, int64_t k, const lt_int8_range *r, const lt_real *w, lt_real *packed, void *work)
{
    const weights words = { work, int8_words(k) };
    const lt_product p = { .k = words.k, .ctx = &words, .pack_b = pack_weights };
    lt_real *scale = packed + lt_product_packed_b(n, words.k);

    int8_weights(w, n, k, 1, r, work, scale, scale + n);
    lt_product_pack_b(&p, 1, n, LT_TILE_N, packed);
}

/* ---- the product -------------------------------------------------------------------------------------- */

typedef struct {
    lt_product product;
    int64_t m, n, tile_m, tile_n, tiles_n;
    int64_t k;                          /* of a row of a */
    const lt_int8_range *r;
    const lt_real *a;
    lt_real *rows;
} job;

enum { ROWS = 32 };                     /* of a that a task makes words of */

static void input_task(void *ctx, int64_t task)
{
    const job *j = ctx;
    const int64_t to = lt_min_i64(j->m, (task + 1) * ROWS);

    for (int64_t i = task * ROWS; i < to; i++)
        lt_k->bytes_of_row(j->rows + i * j->product.ld_rows, j->a + i * j->k, j->r, (size_t)j->k);
}

static void run_tile(void *ctx, int64_t task)
{
    const job *j = ctx;
    const int64_t m0 = task / j->tiles_n * j->tile_m, n0 = task % j->tiles_n * j->tile_n;
    const lt_tile t = { m0, lt_min_i64(j->tile_m, j->m - m0), n0, lt_min_i64(j->tile_n, j->n - n0) };
    lt_product p = j->product;

    p.c += m0 * p.ldc + n0;
    lt_product_tile(&p, &t, 0, 1);
}

size_t lt_gemm_int8_work(int64_t m, int64_t k)
{
    return (size_t)(m * row_words(k)) * sizeof(lt_real);
}

void lt_gemm_int8(int64_t m, int64_t n, int64_t k, const lt_int8_range *r, const lt_real *a, const lt_real *packed,
                  const lt_epilogue *e, lt_real *c, void *work)
{
    const int64_t words = int8_words(k);
    const lt_real *scale = packed + lt_product_packed_b(n, words);
    const lt_bytes bytes = { .start = r->has_negative ? scale + n : NULL, .scale = scale };
    const bool large = m * n >= 8 * LT_TILE_M * 256;
    job j = {
        .product = { .k = words, .rows = work, .ld_rows = row_words(k), .b = packed, .b_columns = n, .c = c,
                     .ldc = n, .bytes = &bytes, .e = e },
        .m = m, .n = n, .tile_m = lt_tile_size(m, large ? LT_TILE_M : LT_FEW_ROWS, 1),
        .tile_n = lt_product_columns(m, n), .k = k, .r = r, .a = a, .rows = work,
    };

    if (m <= 0)
        return;
    j.tiles_n = lt_ceil_div(n, j.tile_n);
    lt_parallel_for(lt_ceil_div(m, ROWS), input_task, &j);
    lt_parallel_for(lt_ceil_div(m, j.tile_m) * j.tiles_n, run_tile, &j);
}
