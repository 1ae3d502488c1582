/* SPDX-License-Identifier: Apache-2.0 */
/* quick_gelu: y = x / (1 + exp(-1.702 x))                    [Hendrycks and Gimpel 2016, section 2; CLIP's activation]
 *   dx += dy * s (1 + 1.702 x (1 - s)), s = sigmoid(1.702 x)
 */
#include "libtensor/ops/common.h"

static void forward(const lt_call *c)
{
    op_map(c, lt_k->quick_gelu);
}

static void backward(const lt_call *c)
{
    op_map_grad(c, lt_k->quick_gelu_grad, c->in[0]);
}

static bool as_tail(const lt_node *node, int i, lt_tail *tail)
{
    (void)node;
    (void)i;
    tail->act = (lt_act){ .kind = LT_ACT_QUICK_GELU };
    return true;
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const char *x = lt_onnx_of(w, n->in[0]), *s = LT_ONNX(w, "Sigmoid", LT_ONNX(w, "Mul", x, lt_onnx_number(w, 1.702)));

    lt_onnx_is(w, n->outs[0], LT_ONNX(w, "Mul", x, s));
}

static const lt_op quick_gelu_op = {
    .name = "quick_gelu", .flags = LT_OP_INPLACE | LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(0),
    .infer = op_same_shape, .forward = forward, .backward = backward, .as_tail = as_tail, .onnx = onnx,
};

lt_tensor *(lt_quick_gelu)(lt_tensor *x)
{
    return lt_apply(&quick_gelu_op, NULL, 0, &x, 1);
}
