/* SPDX-License-Identifier: Apache-2.0 */
/* elu: y = x where x > 0, exp(x) - 1 elsewhere                                [Clevert et al. 2016]
 *   dx += dy * (x > 0 ? 1 : exp(x))
 */
#include "libtensor/ops/common.h"

static void forward_chunk(const lt_call *c, int64_t at, size_t n)
{
    lt_k->elu((lt_real *)c->out->data + at, (const lt_real *)c->in[0]->data + at, 1, n);
}

static void forward(const lt_call *c)
{
    op_by_chunk(c, lt_numel(c->out), forward_chunk);
}

static void backward_chunk(const lt_call *c, int64_t at, size_t n)
{
    op_start(c, 0, at, (int64_t)n);
    lt_k->elu_grad(c->din[0] + at, c->dout + at, (const lt_real *)c->in[0]->data + at, 1, n);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        op_by_chunk(c, lt_numel(c->out), backward_chunk);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "Elu");
}

static const lt_op elu_op = {
    .name = "elu", .flags = LT_OP_INPLACE | LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(0), .infer = op_same_shape,
    .forward = forward, .backward = backward, .onnx = onnx,
};

lt_tensor *(lt_elu)(lt_tensor *x)
{
    return lt_apply(&elu_op, NULL, 0, &x, 1);
}
