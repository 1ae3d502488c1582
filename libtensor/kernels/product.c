/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/kernels/product.h"

#include "libtensor/base/arena.h"

#include <pthread.h>

/*
 * Packing scratch: one per thread, made when the thread first needs it, freed when it ends. Without
 * memory a small one on the stack serves: blocks become smaller, and the result stays the same.
 */
typedef struct { lt_real a[LT_TILE_M * LT_PACK_K], b[LT_TILE_N * LT_PACK_K]; } scratch;

enum { SMALL_K = 16 };
typedef struct { lt_real a[LT_TILE_M * SMALL_K], b[LT_TILE_N * SMALL_K]; } small_scratch;

static pthread_key_t key;
static pthread_once_t key_once = PTHREAD_ONCE_INIT;
static bool have_key;

static void make_key(void)
{
    have_key = pthread_key_create(&key, lt_release) == 0;
}

static scratch *thread_scratch(void)
{
    scratch *s;

    pthread_once(&key_once, make_key);
    if (!have_key)
        return NULL;
    s = pthread_getspecific(key);
    if (s)
        return s;
    s = lt_alloc(sizeof(*s));
    if (s && pthread_setspecific(key, s)) {
        lt_release(s);
        return NULL;
    }
    return s;
}

/* n columns of the tile from its column j: what follows the sum. */
static void finish(const lt_product *p, const lt_tile *t, int64_t image, int64_t j, int64_t n)
{
    const int64_t n0 = t->n0 + j;
    lt_epilogue e = *p->e;

    if (e.row_bias)
        e.row_bias += t->m0;
    if (e.col_bias)
        e.col_bias += n0;
    if (e.residual)
        e.residual += image * p->c_step + t->m0 * e.ld_residual + n0;
    lt_k->epilogue(p->c + image * p->c_step + j, p->ldc, t->m, n, &e);
}

/* Strips of one image for k of the rows: the packed panel of B stays in L1 while A streams past. */
static void strips(const lt_product *p, const lt_tile *t, int64_t image, const lt_real *a,
                   const lt_real *b, int64_t k, bool add, bool last)
{
    const int64_t nr = lt_k->nr;
    lt_real *c = p->c + image * p->c_step;

    for (int64_t j = 0; j < t->n; j += nr) {
        const int64_t n = lt_min_i64(nr, t->n - j);

        lt_k->gemm_strip(c + j, p->ldc, a, b + j * k, t->m, n, k, add);
        if (last && p->e)
            finish(p, t, image, j, n);
    }
}

static void blocks(const lt_product *p, const lt_tile *t, int64_t from, int64_t to, lt_real *a,
                   lt_real *b, int64_t most_k)
{
    const int64_t n_blocks = lt_max_i64(1, lt_ceil_div(p->k, most_k));

    for (int64_t i = 0; i < n_blocks; i++) {
        const int64_t k0 = i * p->k / n_blocks, k = (i + 1) * p->k / n_blocks - k0;

        p->pack_a(p->ctx, a, t, k0, k);
        for (int64_t image = from; image < to; image++) {
            p->pack_b(p->ctx, b, t, image, k0, k);
            strips(p, t, image, a, b, k, p->add || i > 0, i == n_blocks - 1);
        }
    }
}

static __attribute__((noinline)) void small_blocks(const lt_product *p, const lt_tile *t, int64_t from,
                                                   int64_t to)
{
    _Alignas(LT_ALIGN) small_scratch s;

    blocks(p, t, from, to, s.a, s.b, SMALL_K);
}

void lt_product_tile(const lt_product *p, const lt_tile *t, int64_t from, int64_t to)
{
    scratch *s = thread_scratch();

    if (s)
        blocks(p, t, from, to, s->a, s->b, LT_PACK_K);
    else
        small_blocks(p, t, from, to);
}
