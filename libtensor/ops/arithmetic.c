/* SPDX-License-Identifier: Apache-2.0 */
/* add, sub, mul: y = a + b, a - b, a * b, with broadcasting.
 *   add  da += dy      db += dy
 *   sub  da += dy      db -= dy
 *   mul  da += dy b    db += dy a
 *
 * One file for the three: they differ in one line each. Where an operand stretches, its gradient is the
 * sum over what it was stretched to, taken in the order of the elements by one thread.
 */
#include "libtensor/ops/broadcast.h"

/* ---- forward ------------------------------------------------------------------------------------------ */

typedef void (*row_fn)(lt_real *y, const lt_real *a, const lt_real *b, int64_t sa, int64_t sb, size_t n);

static void add_row(lt_real *y, const lt_real *a, const lt_real *b, int64_t sa, int64_t sb, size_t n)
{
    if (sa && sb)
        lt_k->add(y, a, b, n);
    else
        for (size_t i = 0; i < n; i++)
            y[i] = a[(int64_t)i * sa] + b[(int64_t)i * sb];
}

static void sub_row(lt_real *y, const lt_real *a, const lt_real *b, int64_t sa, int64_t sb, size_t n)
{
    if (sa && sb)
        lt_k->sub(y, a, b, n);
    else
        for (size_t i = 0; i < n; i++)
            y[i] = a[(int64_t)i * sa] - b[(int64_t)i * sb];
}

static void mul_row(lt_real *y, const lt_real *a, const lt_real *b, int64_t sa, int64_t sb, size_t n)
{
    if (sa && sb)
        lt_k->mul(y, a, b, n);
    else if (sa)
        lt_k->scale(y, a, *b, n);
    else if (sb)
        lt_k->scale(y, b, *a, n);
    else
        for (size_t i = 0; i < n; i++)
            y[i] = *a * *b;
}

typedef struct {
    const lt_call *c;
    broadcast b;
    row_fn fn;
    int64_t rows_per_task, pieces, piece;       /* long rows are cut, short ones bundled */
} forward_job;

enum { TASK = 16384 };

static void forward_task(void *ctx, int64_t i)
{
    const forward_job *j = ctx;
    const int64_t at = i % j->pieces * j->piece, n = lt_min_i64(j->piece, j->b.inner - at);
    const int64_t first = i / j->pieces * j->rows_per_task;
    const int64_t end = lt_min_i64(j->b.n_rows, first + j->rows_per_task);

    for (int64_t r = first; r < end; r++) {
        const lt_real *a = (const lt_real *)j->c->in[0]->data + broadcast_row(&j->b, 0, r);
        const lt_real *b = (const lt_real *)j->c->in[1]->data + broadcast_row(&j->b, 1, r);

        j->fn((lt_real *)j->c->out->data + r * j->b.inner + at, a + at * j->b.step[0],
              b + at * j->b.step[1], j->b.step[0], j->b.step[1], (size_t)n);
    }
}

static void run_forward(const lt_call *c, row_fn fn)
{
    forward_job j = { .c = c, .b = broadcast_plan(c->out, c->in[0], c->in[1]), .fn = fn };

    if (lt_numel(c->out) == 0)
        return;
    j.piece = lt_min_i64(TASK, j.b.inner);
    j.pieces = lt_ceil_div(j.b.inner, j.piece);
    j.rows_per_task = lt_max_i64(1, TASK / j.b.inner);
    lt_parallel_for(j.pieces * lt_ceil_div(j.b.n_rows, j.rows_per_task), forward_task, &j);
}

static void add_forward(const lt_call *c) { run_forward(c, add_row); }
static void sub_forward(const lt_call *c) { run_forward(c, sub_row); }
static void mul_forward(const lt_call *c) { run_forward(c, mul_row); }

/* ---- backward ----------------------------------------------------------------------------------------- */

/* dx += sign * dy * other, where other may be NULL for 1; x, other stretch by their steps. */
static void grad_row(lt_real *dx, int64_t sx, const lt_real *dy, lt_real sign, const lt_real *other,
                     int64_t so, size_t n)
{
    if (sx == 0) {
        double sum = !other ? lt_k->sum(dy, n) : so ? lt_k->dot(dy, other, n) : lt_k->sum(dy, n) * *other;

        *dx += sign * (lt_real)sum;
    } else if (!other) {
        lt_k->axpy(dx, sign, dy, n);
    } else if (so == 0) {
        lt_k->axpy(dx, sign * *other, dy, n);
    } else {
        lt_k->mul_to(dx, dy, other, n);
    }
}

typedef struct {
    const lt_call *c;
    broadcast b;
    int operand;
    lt_real sign;
    bool product;
} backward_job;

static void backward_row(const backward_job *j, int64_t r)
{
    const int k = j->operand;
    const lt_real *other = j->product ? j->c->in[1 - k]->data : NULL;

    grad_row(j->c->din[k] + broadcast_row(&j->b, k, r), j->b.step[k], j->c->dout + r * j->b.inner,
             j->sign, other ? other + broadcast_row(&j->b, 1 - k, r) : NULL, j->b.step[1 - k],
             (size_t)j->b.inner);
}

static void backward_task(void *ctx, int64_t row)
{
    backward_row(ctx, row);
}

/* Rows may run side by side only where no two of them reach the same place of x. */
static bool rows_are_apart(const broadcast *b, int operand)
{
    for (int i = 1; i < b->rank; i++)
        if (b->stride[operand][i] == 0)
            return false;
    return true;
}

static void run_backward(const lt_call *c, int operand, lt_real sign, bool product)
{
    backward_job j = { c, broadcast_plan(c->out, c->in[0], c->in[1]), operand, sign, product };

    if (!c->din[operand] || lt_numel(c->out) == 0)
        return;
    if (rows_are_apart(&j.b, operand)) {
        lt_parallel_for(j.b.n_rows, backward_task, &j);
        return;
    }
    for (int64_t r = 0; r < j.b.n_rows; r++)
        backward_row(&j, r);
}

static void add_backward(const lt_call *c)
{
    run_backward(c, 0, 1, false);
    run_backward(c, 1, 1, false);
}

static void sub_backward(const lt_call *c)
{
    run_backward(c, 0, 1, false);
    run_backward(c, 1, -1, false);
}

static void mul_backward(const lt_call *c)
{
    run_backward(c, 0, 1, true);
    run_backward(c, 1, 1, true);
}

/* ---- the ops ------------------------------------------------------------------------------------------ */

/* A residual sum is a tail on either of its operands when neither stretches. */
static bool add_as_tail(const lt_node *n, int i, lt_tail *tail)
{
    tail->addend = n->in[1 - i];
    return n->in[0] != n->in[1] && lt_same_shape(&n->in[0]->shape, &n->in[1]->shape);
}

static const lt_op add_op = {
    .name = "add", .keeps = LT_KEEP_NOTHING, .infer = broadcast_infer,
    .forward = add_forward, .backward = add_backward, .as_tail = add_as_tail,
};

static const lt_op sub_op = {
    .name = "sub", .keeps = LT_KEEP_NOTHING, .infer = broadcast_infer,
    .forward = sub_forward, .backward = sub_backward,
};

static const lt_op mul_op = {
    .name = "mul", .keeps = LT_KEEP_IN(0) | LT_KEEP_IN(1), .infer = broadcast_infer,
    .forward = mul_forward, .backward = mul_backward,
};

lt_tensor *(lt_add)(lt_tensor *a, lt_tensor *b)
{
    return lt_apply(&add_op, NULL, 0, (lt_tensor *[]){ a, b }, 2);
}

lt_tensor *(lt_sub)(lt_tensor *a, lt_tensor *b)
{
    return lt_apply(&sub_op, NULL, 0, (lt_tensor *[]){ a, b }, 2);
}

lt_tensor *(lt_mul)(lt_tensor *a, lt_tensor *b)
{
    return lt_apply(&mul_op, NULL, 0, (lt_tensor *[]){ a, b }, 2);
}
