/* SPDX-License-Identifier: Apache-2.0 */
/* tanh: y = (exp(x) - exp(-x)) / (exp(x) + exp(-x))
 *   dx += dy * (1 - y^2)
 */
#include "libtensor/ops/common.h"

static void forward(const lt_call *c)
{
    op_map(c, lt_k->tanh);
}

static void backward(const lt_call *c)
{
    op_map_grad(c, lt_k->tanh_grad, c->out);
}

static bool as_tail(const lt_node *node, int i, lt_tail *tail)
{
    (void)node;
    (void)i;
    tail->act = (lt_act){ .kind = LT_ACT_TANH };
    return true;
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "Tanh");
}

static const lt_op tanh_op = {
    .name = "tanh", .flags = LT_OP_INPLACE | LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_OUT(0),
    .infer = op_same_shape, .forward = forward, .backward = backward, .as_tail = as_tail, .onnx = onnx,
};

lt_tensor *(lt_tanh)(lt_tensor *x)
{
    return lt_apply(&tanh_op, NULL, 0, &x, 1);
}
