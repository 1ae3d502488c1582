/* SPDX-License-Identifier: Apache-2.0 */
/* What a tile of a product works with: memory to pack into, and its part of what follows the sums. */
#include "libtensor/kernels/gemm/product.h"

#include "libtensor/base/arena.h"

#include <pthread.h>

/*
 * Packing scratch: one per thread, made when the thread first needs it, freed when it ends. Without
 * memory one on the stack serves.
 */
typedef struct { lt_real a[LT_SCRATCH_A], b[LT_SCRATCH_B]; } scratch;

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

/* Where there is no memory: kept out of line, or every caller's frame would be as large */
static __attribute__((noinline)) void with_stack_scratch(void (*fn)(void *ctx, lt_real *a, lt_real *b), void *ctx)
{
    _Alignas(LT_ALIGN) scratch s;

    fn(ctx, s.a, s.b);
}

void lt_with_scratch(void (*fn)(void *ctx, lt_real *a, lt_real *b), void *ctx)
{
    scratch *s = thread_scratch();

    if (s)
        fn(ctx, s->a, s->b);
    else
        with_stack_scratch(fn, ctx);
}

lt_epilogue lt_product_epilogue(const lt_product *p, const lt_tile *t, int64_t image)
{
    lt_epilogue e = *p->e;

    e.row_bias = e.row_bias ? e.row_bias + t->m0 : NULL;
    e.col_bias = e.col_bias ? e.col_bias + t->n0 : NULL;
    if (e.residual)
        e.residual += image * p->c_step + t->m0 * e.ld_residual + t->n0;
    return e;
}
