/* SPDX-License-Identifier: Apache-2.0 */
/* stochastic_depth: y = x * m / (1 - p), m of a sample 0 with probability p, else 1    [Huang et al. 2016]
 *   x (B, ...)   ->   y (the shape of x)
 *   dx += dy * m / (1 - p)
 *
 * Draw i is the key of sample i, so backward makes the mask again.
 */
#include "libtensor/ops/common.h"

typedef struct {
    double p;
} stochastic_depth_attr;

static lt_status infer(lt_call *c)
{
    const stochastic_depth_attr *a = c->attr;

    if (!(a->p >= 0 && a->p < 1))
        return lt_fail(c, "p is %g, want 0 <= p < 1", a->p);
    if (c->in[0]->shape.rank < 1)
        return lt_fail(c, "its input is a single number, want samples along a dimension");
    return op_same_shape(c);
}

static lt_real mask(const lt_call *c, int64_t sample)
{
    const stochastic_depth_attr *a = c->attr;
    lt_rng r = c->rng;

    r.index = (uint64_t)sample;
    return lt_rng_u32(&r) * 0x1p-32 < a->p ? 0 : (lt_real)(1 / (1 - a->p));
}

static void forward_sample(const lt_call *c, int64_t i)
{
    const int64_t n = op_inner(c->out, 0);

    lt_k->scale((lt_real *)c->out->data + i * n, (const lt_real *)c->in[0]->data + i * n, mask(c, i), (size_t)n);
}

static void forward(const lt_call *c)
{
    op_by_row(c, lt_dim(c->out, 0), op_inner(c->out, 0), forward_sample);
}

static void backward_sample(const lt_call *c, int64_t i)
{
    const int64_t n = op_inner(c->out, 0);

    lt_k->axpy(c->din[0] + i * n, mask(c, i), c->dout + i * n, (size_t)n);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        op_by_row(c, lt_dim(c->out, 0), op_inner(c->out, 0), backward_sample);
}

static lt_tensor *lower(const lt_node *node, lt_tensor *const *in)
{
    (void)node;
    return in[0];
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_is(w, n->outs[0], lt_onnx_of(w, n->in[0]));
}

static const lt_op stochastic_depth_op = {
    .name = "stochastic_depth", .flags = LT_OP_INPLACE | LT_OP_CHEAP | LT_OP_RANDOM, .keeps = LT_KEEP_NOTHING,
    .infer = infer, .forward = forward, .backward = backward, .lower = lower, .onnx = onnx,
};

lt_tensor *(lt_stochastic_depth)(lt_tensor *x, double p)
{
    const stochastic_depth_attr a = { .p = p };

    return lt_apply(&stochastic_depth_op, &a, sizeof(a), &x, 1);
}
