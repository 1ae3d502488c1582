/* SPDX-License-Identifier: Apache-2.0 */
/* gelu: y = x (1 + erf(x / sqrt 2)) / 2                                [Hendrycks and Gimpel 2016]
 *   dx += dy * (Phi(x) + x phi(x)), Phi and phi the normal distribution and its density
 */
#include "libtensor/ops/common.h"

static void forward(const lt_call *c)
{
    op_map(c, lt_k->gelu);
}

static void backward(const lt_call *c)
{
    op_map_grad(c, lt_k->gelu_grad, c->in[0]);
}

static bool as_tail(const lt_node *node, int i, lt_tail *tail)
{
    (void)node;
    (void)i;
    tail->act = (lt_act){ .kind = LT_ACT_GELU };
    return true;
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const char *x = lt_onnx_of(w, n->in[0]), *y;

    y = LT_ONNX(w, "Erf", LT_ONNX(w, "Mul", x, lt_onnx_number(w, M_SQRT1_2)));
    y = LT_ONNX(w, "Mul", x, LT_ONNX(w, "Add", y, lt_onnx_number(w, 1)));
    lt_onnx_is(w, n->outs[0], LT_ONNX(w, "Mul", y, lt_onnx_number(w, 0.5)));
}

static const lt_op gelu_op = {
    .name = "gelu", .flags = LT_OP_INPLACE | LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(0),
    .infer = op_same_shape, .forward = forward, .backward = backward, .as_tail = as_tail, .onnx = onnx,
};

lt_tensor *(lt_gelu)(lt_tensor *x)
{
    return lt_apply(&gelu_op, NULL, 0, &x, 1);
}
