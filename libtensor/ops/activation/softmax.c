/* SPDX-License-Identifier: Apache-2.0 */
/* softmax: y = exp(x - max) / sum over the last dimension.
 *   dx += y (dy - sum(dy y))
 */
#include "libtensor/ops/common.h"

static lt_status infer(lt_call *c)
{
    if (c->in[0]->shape.rank < 1)
        return lt_fail(c, "its input is a single number, want a row at least");
    return op_same_shape(c);
}

static void forward_row(const lt_call *c, int64_t row)
{
    const int64_t n = lt_dim(c->out, -1);

    lt_k->softmax((lt_real *)c->out->data + row * n, (const lt_real *)c->in[0]->data + row * n, (size_t)n);
}

static void backward_row(const lt_call *c, int64_t row)
{
    const int64_t n = lt_dim(c->out, -1);

    op_start(c, 0, row * n, n);
    lt_k->softmax_grad(c->din[0] + row * n, c->dout + row * n, (const lt_real *)c->out->data + row * n,
                       (size_t)n);
}

static void by_row(const lt_call *c, op_row_fn fn)
{
    const int64_t n = lt_dim(c->out, -1);

    if (n)
        op_by_row(c, lt_numel(c->out) / n, 4 * n, fn);
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

static void onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "Softmax");
    lt_onnx_int(w, "axis", -1);
}

static const lt_op softmax_op = {
    .name = "softmax", .flags = LT_OP_INPLACE | LT_OP_ASSIGNS, .keeps = LT_KEEP_OUT(0), .infer = infer,
    .forward = forward, .backward = backward, .onnx = onnx,
};

lt_tensor *(lt_softmax)(lt_tensor *x)
{
    return lt_apply(&softmax_op, NULL, 0, &x, 1);
}
