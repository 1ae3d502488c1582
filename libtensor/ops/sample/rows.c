/* SPDX-License-Identifier: Apache-2.0 */
/* rows: a range of rows whose place is data.
 *   x (N, ...)   first () or (1), an integer   ->   y (n, ...):   y[i] = x[first + i], 0 where x has no such row
 *   dx[first + i] += dy[i]
 *
 * Where x is a parameter that is stepped by rows (libtensor/graph/rows.h), rows that are not touched get nothing.
 */
#include "libtensor/graph/rows.h"
#include "libtensor/ops/common.h"

typedef struct { int64_t n; } rows_attr;

static lt_status infer(lt_call *c)
{
    const rows_attr *a = c->attr;
    const lt_tensor *x = c->in[0], *first = c->in[1];
    char text[LT_SHAPE_TEXT];

    if (x->shape.rank < 1)
        return lt_fail(c, "its input is a number, want rows");
    if (first->dtype != LT_I32 || lt_numel(first) != 1)
        return lt_fail(c, "the first row is %s%s, want one integer", lt_shape_text(&first->shape, text),
                       first->dtype == LT_I32 ? "" : " and no LT_I32");
    if (a->n < 0 || a->n > lt_dim(x, 0))
        return lt_fail(c, "%lld rows of %lld", (long long)a->n, (long long)lt_dim(x, 0));
    c->out->shape = x->shape;
    c->out->shape.dim[0] = a->n;
    return LT_OK;
}

static int64_t width_of(const lt_call *c)
{
    return op_inner(c->in[0], 0);
}

/* Row i of y is this one of x; or -1 */
static int64_t place_of(const lt_call *c, int64_t i)
{
    const int64_t at = *(const int32_t *)c->in[1]->data + i;

    return at >= 0 && at < lt_dim(c->in[0], 0) ? at : -1;
}

static void forward_row(const lt_call *c, int64_t i)
{
    const int64_t width = width_of(c), at = place_of(c, i);
    lt_real *y = (lt_real *)c->out->data + i * width;

    if (at < 0)
        memset(y, 0, (size_t)width * sizeof(*y));
    else
        memcpy(y, (const lt_real *)c->in[0]->data + at * width, (size_t)width * sizeof(*y));
}

static void backward_row(const lt_call *c, int64_t i)
{
    const lt_param *p = c->in[0]->param;
    const int64_t width = width_of(c), at = place_of(c, i);

    if (at >= 0 && (!p || !p->rows || lt_param_is_touched(p, at)))
        lt_k->add_to(c->din[0] + at * width, c->dout + i * width, (size_t)width);
}

static void by_row(const lt_call *c, op_row_fn fn)
{
    op_by_row(c, lt_dim(c->out, 0), width_of(c), fn);
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

static const lt_op rows_op = {
    .name = "rows", .flags = LT_OP_ROWS, .keeps = LT_KEEP_IN(1), .any_type = LT_ANY_TYPE_IN(1), .infer = infer,
    .forward = forward, .backward = backward,
};

lt_tensor *(lt_rows)(lt_tensor *x, lt_tensor *first, int64_t n)
{
    const rows_attr a = { n };

    return lt_apply(&rows_op, &a, sizeof(a), (lt_tensor *[]){ x, first }, 2);
}
