/* SPDX-License-Identifier: Apache-2.0 */
/* scale: y = s x for a number known while recording
 *   dx += s dy
 */
#include "libtensor/ops/common.h"

typedef struct {
    lt_real s;
} scale_attr;

static void forward_chunk(const lt_call *c, int64_t at, size_t n)
{
    const scale_attr *a = c->attr;

    lt_k->scale((lt_real *)c->out->data + at, (const lt_real *)c->in[0]->data + at, a->s, n);
}

static void forward(const lt_call *c)
{
    op_by_chunk(c, lt_numel(c->out), forward_chunk);
}

static void backward_chunk(const lt_call *c, int64_t at, size_t n)
{
    const scale_attr *a = c->attr;

    op_start(c, 0, at, (int64_t)n);
    lt_k->axpy(c->din[0] + at, a->s, c->dout + at, n);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        op_by_chunk(c, lt_numel(c->out), backward_chunk);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const scale_attr *a = n->attr;

    lt_onnx_is(w, n->outs[0], LT_ONNX(w, "Mul", lt_onnx_of(w, n->in[0]), lt_onnx_number(w, a->s)));
}

static const lt_op scale_op = {
    .name = "scale", .flags = LT_OP_INPLACE | LT_OP_CHEAP | LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING,
    .infer = op_same_shape, .forward = forward, .backward = backward, .onnx = onnx,
};

lt_tensor *(lt_scale)(lt_tensor *x, double s)
{
    const scale_attr a = { .s = (lt_real)s };

    return lt_apply(&scale_op, &a, sizeof(a), &x, 1);
}
