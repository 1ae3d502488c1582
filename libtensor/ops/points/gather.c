/* SPDX-License-Identifier: Apache-2.0 */
/* gather: rows by index, each set of the batch from its own.
 *   x (B, N, ...)   index (B, ...), integers   ->   y (B, ..., ...):   y[b, i] = x[b, index[b, i]], 0 where x has no
 *                                                                      such row
 *   dx[b, index[b, i]] += dy[b, i]        in the order of i; each row of dx has one owner
 */
#include "libtensor/ops/common.h"

enum { X, INDEX };

static int64_t width_of(const lt_call *c)
{
    return op_inner(c->in[X], 1);
}

/* Rows of y of one set */
static int64_t taken(const lt_call *c)
{
    return op_inner(c->in[INDEX], 0);
}

static lt_status infer(lt_call *c)
{
    const lt_shape *x = &c->in[X]->shape, *index = &c->in[INDEX]->shape;
    lt_shape *y = &c->out->shape;
    char text[LT_SHAPE_TEXT];

    if (x->rank < 2 || x->dim[1] > INT32_MAX)
        return lt_fail(c, "its input is %s, want (batch, rows, ...)", lt_shape_text(x, text));
    if (c->in[INDEX]->dtype != LT_I32 || index->rank < 2 || index->dim[0] != x->dim[0])
        return lt_fail(c, "the index is %s%s, want integers for %lld sets", lt_shape_text(index, text),
                       c->in[INDEX]->dtype == LT_I32 ? "" : " and no LT_I32", (long long)x->dim[0]);
    if (index->rank + x->rank - 2 > LT_MAX_RANK)
        return lt_fail(c, "a result of %d dimensions, at most %d can be", index->rank + x->rank - 2, LT_MAX_RANK);
    *y = *index;
    for (int i = 2; i < x->rank; i++)
        y->dim[y->rank++] = x->dim[i];
    return LT_OK;
}

/* work, on the way back: where the list of each row of x begins, and the lists, of rows of y in their order */
static void plan(lt_call *c)
{
    if (c->train)
        c->work_bytes = (size_t)(op_outer(c->in[X], 2) + 1 + lt_numel(c->in[INDEX])) * sizeof(int64_t);
}

/* Row i of y is this one of x, in the whole batch; or -1 */
static int64_t source(const lt_call *c, int64_t i)
{
    const int64_t N = lt_dim(c->in[X], 1), at = ((const int32_t *)c->in[INDEX]->data)[i];

    return at >= 0 && at < N ? i / taken(c) * N + at : -1;
}

static void forward_row(const lt_call *c, int64_t i)
{
    const int64_t width = width_of(c), at = source(c, i);
    lt_real *y = (lt_real *)c->out->data + i * width;

    if (at < 0)
        memset(y, 0, (size_t)width * sizeof(*y));
    else
        memcpy(y, (const lt_real *)c->in[X]->data + at * width, (size_t)width * sizeof(*y));
}

static void forward(const lt_call *c)
{
    op_by_row(c, lt_numel(c->in[INDEX]), width_of(c), forward_row);
}

/* A counting sort: begin[r] .. begin[r + 1] are row r's in list. begin is one ahead while places are handed out. */
static void make_lists(const lt_call *c)
{
    const int64_t rows = op_outer(c->in[X], 2), n = lt_numel(c->in[INDEX]);
    int64_t *begin = c->work, *list = begin + rows + 1;

    memset(begin, 0, (size_t)(rows + 1) * sizeof(*begin));
    for (int64_t i = 0; i < n; i++)
        if (source(c, i) >= 0)
            begin[source(c, i) + 1]++;
    for (int64_t r = 0; r < rows; r++)
        begin[r + 1] += begin[r];
    for (int64_t i = 0; i < n; i++)
        if (source(c, i) >= 0)
            list[begin[source(c, i)]++] = i;
    memmove(begin + 1, begin, (size_t)rows * sizeof(*begin));
    begin[0] = 0;
}

static void backward_row(const lt_call *c, int64_t r)
{
    const int64_t rows = op_outer(c->in[X], 2), width = width_of(c);
    const int64_t *begin = c->work, *list = begin + rows + 1;

    op_start(c, X, r * width, width);
    for (int64_t k = begin[r]; k < begin[r + 1]; k++)
        lt_k->add_to(c->din[X] + r * width, c->dout + list[k] * width, (size_t)width);
}

static void backward(const lt_call *c)
{
    if (!c->din[X])
        return;
    make_lists(c);
    op_by_row(c, op_outer(c->in[X], 2), width_of(c) * lt_max_i64(1, taken(c) / lt_max_i64(1, lt_dim(c->in[X], 1))),
              backward_row);
}

static const lt_op gather_op = {
    .name = "gather", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(INDEX), .any_type = LT_ANY_TYPE_IN(INDEX),
    .infer = infer, .plan = plan, .forward = forward, .backward = backward,
};

lt_tensor *(lt_gather)(lt_tensor *x, lt_tensor *index)
{
    return lt_apply(&gather_op, NULL, 0, (lt_tensor *[]){ x, index }, 2);
}
