/* SPDX-License-Identifier: Apache-2.0 */
/* dropout: y = x * m / (1 - p), m = 0 with probability p, else 1          [Srivastava et al. 2014]
 *   dx += dy * m / (1 - p)
 *
 * Draw i is the key of element i, so the mask depends on neither threads nor chunks and backward makes
 * it again.
 */
#include "libtensor/ops/common.h"

#include <math.h>

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

/* 0 <= p < 1: a draw u drops its element where u / 2^32 < p. */
static lt_masking mask_of(const lt_call *c)
{
    const dropout_attr *a = c->attr;

    return (lt_masking){
        .seed = c->rng.seed, .stream = c->rng.stream, .below = (uint32_t)fmin(ceil(a->p * 0x1p32), UINT32_MAX),
        .scale = (lt_real)(1 / (1 - a->p)),
    };
}

static void forward_chunk(const lt_call *c, int64_t at, size_t n)
{
    const lt_masking d = mask_of(c);

    lt_k->dropout((lt_real *)c->out->data + at, (const lt_real *)c->in[0]->data + at, &d, at, n, false);
}

static void forward(const lt_call *c)
{
    op_by_chunk(c, lt_numel(c->out), forward_chunk);
}

static void backward_chunk(const lt_call *c, int64_t at, size_t n)
{
    const lt_masking d = mask_of(c);

    lt_k->dropout(c->din[0] + at, c->dout + at, &d, at, n, !c->fresh[0]);
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
    .name = "dropout", .flags = LT_OP_INPLACE | LT_OP_CHEAP | LT_OP_RANDOM | LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING,
    .infer = infer, .forward = forward, .backward = backward, .lower = lower, .onnx = onnx,
};

lt_tensor *(lt_dropout)(lt_tensor *x, double p)
{
    const dropout_attr a = { .p = p };

    return lt_apply(&dropout_op, &a, sizeof(a), &x, 1);
}
