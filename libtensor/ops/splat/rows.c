/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/ops/splat/rows.h"

typedef struct {
    const lt_call *c;
    splat_block_fn fn;
    int64_t n;
} blocks;

static void run_block(void *ctx, int64_t i)
{
    const blocks *b = ctx;

    b->fn(b->c, i * SPLAT_ROWS, lt_min_i64(b->n, (i + 1) * SPLAT_ROWS));
}

void splat_by_block(const lt_call *c, int64_t n, splat_block_fn fn)
{
    blocks b = { c, fn, n };

    lt_parallel_for(lt_ceil_div(n, SPLAT_ROWS), run_block, &b);
}

lt_status splat_want_transforms(lt_call *c, int i, int64_t n)
{
    const lt_shape *s = &c->in[i]->shape;
    char text[LT_SHAPE_TEXT];

    if (s->rank == 3 && (s->dim[0] == n || s->dim[0] == 1) && s->dim[1] == 3 && s->dim[2] == 4)
        return LT_OK;
    return lt_fail(c, "transforms is %s, want (%lld, 3, 4) or (1, 3, 4)", lt_shape_text(s, text), (long long)n);
}

int64_t splat_step(const lt_tensor *transforms, int64_t n)
{
    return lt_dim(transforms, 0) == n ? 12 : 0;
}

size_t splat_shared_bytes(const lt_call *c, int i, int64_t n)
{
    return splat_step(c->in[i], n) ? 0 : (size_t)lt_ceil_div(n, SPLAT_ROWS) * 12 * sizeof(double);
}

double *splat_shared(const lt_call *c, int64_t from)
{
    double *sum = (double *)c->work + from / SPLAT_ROWS * 12;

    memset(sum, 0, 12 * sizeof(*sum));
    return sum;
}

void splat_add_shared(const lt_call *c, int i, int64_t n)
{
    const double *part = c->work;

    if (!c->din[i] || splat_step(c->in[i], n))
        return;
    for (int r = 0; r < 12; r++) {
        double sum = 0;

        for (int64_t block = 0; block < lt_ceil_div(n, SPLAT_ROWS); block++)
            sum += part[block * 12 + r];
        c->din[i][r] += (lt_real)sum;
    }
}
