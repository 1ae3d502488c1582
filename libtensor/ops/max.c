/* SPDX-License-Identifier: Apache-2.0 */
/* max: y = the largest along the last dimension; the first NaN is larger than all.
 *   x (..., K)   ->   y (...)
 *   dx of the first of the largest += dy
 */
#include "libtensor/ops/common.h"

static lt_status infer(lt_call *c)
{
    const lt_shape *x = &c->in[0]->shape;

    if (x->rank < 1 || x->dim[x->rank - 1] < 1 || x->dim[x->rank - 1] > INT32_MAX)
        return lt_fail(c, "its last dimension is empty");
    c->out->shape = *x;
    c->out->shape.rank--;
    return LT_OK;
}

/* saved: where the largest was */
static void plan(lt_call *c)
{
    if (c->train)
        c->saved_bytes[0] = (size_t)lt_numel(c->out) * sizeof(int32_t);
}

enum { ROWS = 64 };                 /* of a task's part */

static int64_t parts_of(const lt_call *c)
{
    return lt_ceil_div(lt_numel(c->out), ROWS);
}

static void forward_part(const lt_call *c, int64_t part)
{
    const int64_t K = lt_dim(c->in[0], -1), row = part * ROWS;

    lt_k->largest_of_rows((lt_real *)c->out->data + row, c->train ? (int32_t *)c->saved[0] + row : NULL,
                          (const lt_real *)c->in[0]->data + row * K, K, lt_min_i64(ROWS, lt_numel(c->out) - row));
}

static void forward(const lt_call *c)
{
    op_by_row(c, parts_of(c), ROWS * lt_dim(c->in[0], -1), forward_part);
}

static void backward_part(const lt_call *c, int64_t part)
{
    const int64_t K = lt_dim(c->in[0], -1), row = part * ROWS, n = lt_min_i64(ROWS, lt_numel(c->out) - row);
    const int32_t *where = c->saved[0];

    op_start(c, 0, row * K, n * K);
    for (int64_t r = row; r < row + n; r++)
        c->din[0][r * K + where[r]] += c->dout[r];
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        op_by_row(c, parts_of(c), ROWS * lt_dim(c->in[0], -1), backward_part);
}

static const lt_op max_op = {
    .name = "max", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = infer, .plan = plan, .forward = forward,
    .backward = backward,
};

lt_tensor *(lt_max)(lt_tensor *x)
{
    return lt_apply(&max_op, NULL, 0, &x, 1);
}
