/* SPDX-License-Identifier: Apache-2.0 */
/* leaky_relu: y = x where x > 0, slope * x elsewhere.            [Maas et al. 2013, section 2]
 *   x (any shape)  ->  y (the shape of x)
 *   dx += dy * (x > 0 ? 1 : slope)                               at x = 0 we take slope
 *
 * The slope is not negative, so y tells the sign of x and x need not be kept.
 */
#include "libtensor/ops/common.h"

typedef struct {
    lt_real slope;
} leaky_relu_attr;

static lt_status infer(lt_call *c)
{
    const leaky_relu_attr *a = c->attr;

    if (!(a->slope >= 0) || isinf(a->slope))
        return lt_fail(c, "slope is %g, want a finite number that is not negative", (double)a->slope);
    return op_same_shape(c);
}

static void forward_chunk(const lt_call *c, int64_t at, size_t n)
{
    const leaky_relu_attr *a = c->attr;
    const lt_real *x = (const lt_real *)c->in[0]->data + at;
    lt_real *y = (lt_real *)c->out->data + at;

    if (a->slope == 0)                  /* 0 times minus infinity is no number */
        lt_k->relu(y, x, n);
    else
        lt_k->leaky_relu(y, x, a->slope, n);
}

static void forward(const lt_call *c)
{
    op_by_chunk(c, lt_numel(c->out), forward_chunk);
}

static void backward_chunk(const lt_call *c, int64_t at, size_t n)
{
    const leaky_relu_attr *a = c->attr;
    const lt_real *y = (const lt_real *)c->out->data + at;

    op_start(c, 0, at, (int64_t)n);
    lt_k->leaky_relu_grad(c->din[0] + at, c->dout + at, y, a->slope, n);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        op_by_chunk(c, lt_numel(c->out), backward_chunk);
}

static bool as_tail(const lt_node *node, int i, lt_tail *tail)
{
    const leaky_relu_attr *a = node->attr;

    (void)i;
    tail->act = (lt_act){ a->slope == 0 ? LT_ACT_RELU : LT_ACT_LEAKY_RELU, a->slope };
    return true;
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const leaky_relu_attr *a = n->attr;

    lt_onnx_same(w, n, a->slope == 0 ? "Relu" : "LeakyRelu");
    if (a->slope != 0)
        lt_onnx_float(w, "alpha", a->slope);
}

static const lt_op leaky_relu_op = {
    .name = "leaky_relu", .flags = LT_OP_INPLACE | LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_OUT(0), .infer = infer,
    .forward = forward, .backward = backward, .as_tail = as_tail, .onnx = onnx,
};

lt_tensor *(lt_leaky_relu)(lt_tensor *x, double slope)
{
    const leaky_relu_attr a = { .slope = (lt_real)slope };

    return lt_apply(&leaky_relu_op, &a, sizeof(a), &x, 1);
}

lt_tensor *(lt_relu)(lt_tensor *x)
{
    return lt_leaky_relu(x, 0);
}
