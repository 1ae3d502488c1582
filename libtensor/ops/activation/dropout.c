/* SPDX-License-Identifier: Apache-2.0 */
/* dropout: y = x * m / (1 - p), m = 0 with probability p, else 1          [Srivastava et al. 2014]
 *   dx += dy * m / (1 - p)
 *
 * Draw i is the key of element i, so the mask depends on neither threads nor chunks and backward makes
 * it again. In a plan with gradients the leaky relu before it may be done here as well:
 * y = leaky_relu(x) * m / (1 - p).
 */
#include "libtensor/ops/common.h"

#include <math.h>

typedef struct {
    double p;
    bool relu;                          /* with a leaky relu of this slope before it */
    lt_real slope;
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

/* y = or += x masked, where the relu saw what in[0] is */
static void mask(const lt_call *c, lt_real *y, const lt_real *x, int64_t at, size_t n, bool add)
{
    const dropout_attr *a = c->attr;
    const lt_masking d = mask_of(c);
    const lt_behind relu = { .y = (const lt_real *)c->in[0]->data + at, .slope = a->slope };

    lt_k->dropout(y + at, x + at, &d, a->relu ? &relu : NULL, at, n, add);
}

static void forward_chunk(const lt_call *c, int64_t at, size_t n)
{
    mask(c, c->out->data, c->in[0]->data, at, n, false);
}

static void forward(const lt_call *c)
{
    op_by_chunk(c, lt_numel(c->out), forward_chunk);
}

static void backward_chunk(const lt_call *c, int64_t at, size_t n)
{
    mask(c, c->din[0], c->dout, at, n, !c->fresh[0]);
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

static bool absorb_before_for_training(lt_node *node, const lt_node *before);

#define DROPOUT(kept) {                                                                             \
    .name = "dropout", .flags = LT_OP_INPLACE | LT_OP_CHEAP | LT_OP_RANDOM | LT_OP_ASSIGNS, .keeps = (kept), \
    .infer = infer, .forward = forward, .backward = backward, .lower = lower, \
    .absorb_before_for_training = absorb_before_for_training, .onnx = onnx, \
}

static const lt_op dropout_op = DROPOUT(LT_KEEP_NOTHING);
static const lt_op after_relu_op = DROPOUT(LT_KEEP_IN(0));

static bool absorb_before_for_training(lt_node *node, const lt_node *before)
{
    dropout_attr *a = node->attr;
    lt_tail tail = { 0 };

    if (a->relu || before->n_in != 1 || !before->op->as_tail || !before->op->as_tail(before, 0, &tail)
        || (tail.act.kind != LT_ACT_RELU && tail.act.kind != LT_ACT_LEAKY_RELU))
        return false;
    a->relu = true;
    a->slope = tail.act.param;
    node->in[0] = before->in[0];
    node->op = &after_relu_op;
    return true;
}

lt_tensor *(lt_dropout)(lt_tensor *x, double p)
{
    const dropout_attr a = { .p = p };

    return lt_apply(&dropout_op, &a, sizeof(a), &x, 1);
}
