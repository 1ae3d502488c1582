/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/ops/common.h"

#include "libtensor/kernels/conv/conv.h"

enum { CHUNK = 16384 };             /* elements of a task: about 5 us of streaming */

lt_status op_same_shape(lt_call *c)
{
    c->out->shape = c->in[0]->shape;
    return LT_OK;
}

lt_status op_check_window(lt_call *c, const lt_tensor *w)
{
    const int64_t kh = lt_dim(w, 2), kw = lt_dim(w, 3), most = LT_CONV_MOST_TAPS;

    if (kh < 1 || kw < 1 || kh > most || kw > most || kh * kw > most)
        return lt_fail(c, "a %lld x %lld window: want 1 to %d elements", (long long)kh, (long long)kw, (int)most);
    return LT_OK;
}

typedef struct {
    const lt_call *c;
    op_chunk_fn fn;
    op_row_fn row_fn;
    int64_t n, per_task;
} cut;

static void run_chunk(void *ctx, int64_t i)
{
    const cut *job = ctx;
    const int64_t at = i * CHUNK;

    job->fn(job->c, at, (size_t)lt_min_i64(CHUNK, job->n - at));
}

void op_by_chunk(const lt_call *c, int64_t n, op_chunk_fn fn)
{
    cut job = { .c = c, .fn = fn, .n = n };

    lt_parallel_for(lt_ceil_div(n, CHUNK), run_chunk, &job);
}

typedef struct {
    const lt_call *c;
    op_map_fn fn;
    op_map_grad_fn grad;
    const lt_real *z;
    int64_t n;
} mapping;

static void map_chunk(void *ctx, int64_t i)
{
    const mapping *m = ctx;
    const int64_t at = i * CHUNK, n = lt_min_i64(CHUNK, m->n - at);

    m->fn((lt_real *)m->c->out->data + at, (const lt_real *)m->c->in[0]->data + at, (size_t)n);
}

static void map_grad_chunk(void *ctx, int64_t i)
{
    const mapping *m = ctx;
    const int64_t at = i * CHUNK, n = lt_min_i64(CHUNK, m->n - at);

    op_start(m->c, 0, at, n);
    m->grad(m->c->din[0] + at, m->c->dout + at, m->z + at, (size_t)n);
}

void op_map(const lt_call *c, op_map_fn fn)
{
    mapping m = { .c = c, .fn = fn, .n = lt_numel(c->out) };

    lt_parallel_for(lt_ceil_div(m.n, CHUNK), map_chunk, &m);
}

void op_map_grad(const lt_call *c, op_map_grad_fn fn, const lt_tensor *z)
{
    mapping m = { .c = c, .grad = fn, .z = z->data, .n = lt_numel(c->out) };

    if (c->din[0])
        lt_parallel_for(lt_ceil_div(m.n, CHUNK), map_grad_chunk, &m);
}

static void run_rows(void *ctx, int64_t i)
{
    const cut *job = ctx;
    const int64_t end = lt_min_i64(job->n, (i + 1) * job->per_task);

    for (int64_t row = i * job->per_task; row < end; row++)
        job->row_fn(job->c, row);
}

void op_by_row(const lt_call *c, int64_t n, int64_t row_cost, op_row_fn fn)
{
    cut job = { .c = c, .row_fn = fn, .n = n };

    job.per_task = lt_max_i64(1, CHUNK / lt_max_i64(1, row_cost));
    lt_parallel_for(lt_ceil_div(n, job.per_task), run_rows, &job);
}

void op_start(const lt_call *c, int i, int64_t at, int64_t n)
{
    if (c->fresh[i])
        memset(c->din[i] + at, 0, (size_t)n * sizeof(lt_real));
}

bool op_fills_blocks(const lt_tensor *t)
{
    return t->shape.rank == 4 && lt_dim(t, 1) > 0 && lt_dim(t, 1) % LT_BLOCK == 0;
}

int64_t op_outer(const lt_tensor *t, int axis)
{
    int64_t n = 1;

    for (int i = 0; i < axis; i++)
        n *= t->shape.dim[i];
    return n;
}

int64_t op_inner(const lt_tensor *t, int axis)
{
    int64_t n = 1;

    for (int i = axis + 1; i < t->shape.rank; i++)
        n *= t->shape.dim[i];
    return n;
}
