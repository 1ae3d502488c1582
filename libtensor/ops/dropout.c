/* SPDX-License-Identifier: Apache-2.0 */
/* dropout: y = x * m / (1 - p), m = 0 with probability p, else 1          [Srivastava et al. 2014]
 *   dx += dy * m / (1 - p)
 *
 * Draw i is the key of element i, so the mask depends on neither threads nor chunks and backward makes
 * it again.
 */
#include "libtensor/ops/common.h"

typedef struct {
    double p;
} dropout_attr;

static lt_status infer(lt_call *c)
{
    const dropout_attr *a = c->attr;

    if (!(a->p >= 0 && a->p < 1))
        return lt_fail(c, "p is %g, want 0 <= p < 1", a->p);
    return op_same_shape(c);
}

static lt_real mask(lt_rng *r, double p)
{
    return lt_rng_u32(r) * 0x1p-32 < p ? 0 : (lt_real)(1 / (1 - p));
}

static void forward_chunk(const lt_call *c, int64_t at, size_t n)
{
    const dropout_attr *a = c->attr;
    const lt_real *x = (const lt_real *)c->in[0]->data + at;
    lt_real *y = (lt_real *)c->out->data + at;
    lt_rng r = c->rng;

    r.index = (uint64_t)at;
    for (size_t i = 0; i < n; i++)
        y[i] = x[i] * mask(&r, a->p);
}

static void forward(const lt_call *c)
{
    op_by_chunk(c, lt_numel(c->out), forward_chunk);
}

static void backward_chunk(const lt_call *c, int64_t at, size_t n)
{
    const dropout_attr *a = c->attr;
    lt_rng r = c->rng;

    r.index = (uint64_t)at;
    for (size_t i = 0; i < n; i++)
        c->din[0][at + (int64_t)i] += c->dout[at + (int64_t)i] * mask(&r, a->p);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        op_by_chunk(c, lt_numel(c->out), backward_chunk);
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

static const lt_op dropout_op = {
    .name = "dropout", .flags = LT_OP_INPLACE | LT_OP_CHEAP | LT_OP_RANDOM, .keeps = LT_KEEP_NOTHING,
    .infer = infer, .forward = forward, .backward = backward, .lower = lower, .onnx = onnx,
};

lt_tensor *(lt_dropout)(lt_tensor *x, double p)
{
    const dropout_attr a = { .p = p };

    return lt_apply(&dropout_op, &a, sizeof(a), &x, 1);
}
