/* SPDX-License-Identifier: Apache-2.0 */
/* elu: y = x where x > 0, exp(x) - 1 elsewhere                                [Clevert et al. 2016]
 *   dx += dy * (x > 0 ? 1 : exp(x))
 */
#include "libtensor/ops/common.h"

static void forward(const lt_call *c)
{
    op_map(c, lt_k->elu);
}

static void backward(const lt_call *c)
{
    op_map_grad(c, lt_k->elu_grad, c->in[0]);
}

static bool as_tail(const lt_node *node, int i, lt_tail *tail)
{
    (void)node;
    (void)i;
    tail->act = (lt_act){ .kind = LT_ACT_ELU };
    return true;
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_same(w, n, "Elu");
}

static const lt_op elu_op = {
    .name = "elu", .flags = LT_OP_INPLACE | LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(0),
    .infer = op_same_shape, .forward = forward, .backward = backward, .as_tail = as_tail, .onnx = onnx,
};

lt_tensor *(lt_elu)(lt_tensor *x)
{
    return lt_apply(&elu_op, NULL, 0, &x, 1);
}
