/* SPDX-License-Identifier: Apache-2.0 */
/* permute: dimension i of y is dimension order[i] of x.
 *   dx += dy with the inverse order
 */
#include "libtensor/ops/common.h"

typedef struct {
    int order[LT_MAX_RANK];
} permute_attr;

static lt_status infer(lt_call *c)
{
    const permute_attr *a = c->attr;
    const lt_shape *x = &c->in[0]->shape;
    unsigned seen = 0;

    for (int i = 0; i < x->rank; i++) {
        if (a->order[i] < 0 || a->order[i] >= x->rank || (seen & (1u << a->order[i])))
            return lt_fail(c, "order[%d] = %d is no permutation of %d dimensions", i, a->order[i], x->rank);
        seen |= 1u << a->order[i];
        c->out->shape.dim[i] = x->dim[a->order[i]];
    }
    c->out->shape.rank = x->rank;
    return LT_OK;
}

/* Where row `row` of y (its last dimension) starts in x, and the step in x along it. */
static int64_t source_of(const lt_call *c, int64_t row, int64_t *step)
{
    const permute_attr *a = c->attr;
    const lt_shape *x = &c->in[0]->shape, *y = &c->out->shape;
    int64_t stride[LT_MAX_RANK], at = 0;

    for (int i = x->rank - 1; i >= 0; i--)
        stride[i] = i == x->rank - 1 ? 1 : stride[i + 1] * x->dim[i + 1];
    for (int i = y->rank - 2; i >= 0; i--) {
        at += row % y->dim[i] * stride[a->order[i]];
        row /= y->dim[i];
    }
    *step = y->rank ? stride[a->order[y->rank - 1]] : 1;
    return at;
}

/* Elements of a row of y; a single number is one. */
static int64_t row_of(const lt_call *c)
{
    return c->out->shape.rank ? lt_dim(c->out, -1) : 1;
}

static void forward_row(const lt_call *c, int64_t row)
{
    const int64_t n = row_of(c);
    int64_t step, at = source_of(c, row, &step);
    const lt_real *x = (const lt_real *)c->in[0]->data + at;
    lt_real *y = (lt_real *)c->out->data + row * n;

    for (int64_t i = 0; i < n; i++)
        y[i] = x[i * step];
}

static void backward_row(const lt_call *c, int64_t row)
{
    const int64_t n = row_of(c);
    int64_t step, at = source_of(c, row, &step);

    for (int64_t i = 0; c->fresh[0] && i < n; i++)
        c->din[0][at + i * step] = 0;
    lt_k->axpy_out(c->din[0] + at, step, 1, c->dout + row * n, (size_t)n);
}

static void by_row(const lt_call *c, op_row_fn fn)
{
    if (lt_numel(c->out))
        op_by_row(c, lt_numel(c->out) / row_of(c), row_of(c), fn);
}

static void forward(const lt_call *c)
{
    by_row(c, forward_row);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        by_row(c, backward_row);
}

static const lt_op permute_op = {
    .name = "permute", .flags = LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = infer,
    .forward = forward, .backward = backward,
};

lt_tensor *(lt_permute)(lt_tensor *x, const int *order)
{
    permute_attr a = { { 0 } };

    memcpy(a.order, order, (size_t)x->shape.rank * sizeof(*order));
    return lt_apply(&permute_op, &a, sizeof(a), &x, 1);
}
