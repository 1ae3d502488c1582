/* SPDX-License-Identifier: Apache-2.0 */
/* channel_affine: y = act(scale[c] x + shift[c]) over dimension 1; a batch norm at inference is one.
 *   x (B, C, ...)   scale, shift (C)   ->   y (B, C, ...)
 *   dx += dy scale      dscale += sum dy x      dshift += sum dy
 */
#include "libtensor/ops/common.h"

enum { X, SCALE, SHIFT };

typedef struct {
    lt_act act;
} affine_attr;

static lt_status infer(lt_call *c)
{
    lt_shape channels;

    if (c->in[X]->shape.rank < 2)
        return lt_fail(c, "its input has no dimension 1 for channels");
    channels = LT_SHAPE(lt_dim(c->in[X], 1));
    if (lt_want_shape(c, SCALE, "scale", channels) || lt_want_shape(c, SHIFT, "shift", channels))
        return LT_ESHAPE;
    return op_same_shape(c);
}

static void forward_plane(const lt_call *c, int64_t i)
{
    const affine_attr *a = c->attr;
    const int64_t n = op_inner(c->out, 1), ch = i % lt_dim(c->out, 1);

    lt_k->affine((lt_real *)c->out->data + i * n, (const lt_real *)c->in[X]->data + i * n,
                 ((const lt_real *)c->in[SCALE]->data)[ch], ((const lt_real *)c->in[SHIFT]->data)[ch], NULL, a->act,
                 (size_t)n);
}

static void forward(const lt_call *c)
{
    op_by_row(c, op_outer(c->out, 2), op_inner(c->out, 1), forward_plane);
}

/* A task owns a channel and takes the images in their order. */
static void backward_channel(const lt_call *c, int64_t ch)
{
    const int64_t n = op_inner(c->out, 1), C = lt_dim(c->out, 1);
    const lt_real scale = ((const lt_real *)c->in[SCALE]->data)[ch];
    double dscale = 0, dshift = 0;

    for (int64_t b = 0; b < lt_dim(c->out, 0); b++) {
        const int64_t at = (b * C + ch) * n;

        dscale += lt_k->dot(c->dout + at, (const lt_real *)c->in[X]->data + at, (size_t)n);
        dshift += lt_k->sum(c->dout + at, (size_t)n);
        op_start(c, X, at, n);
        if (c->din[X])
            lt_k->axpy(c->din[X] + at, scale, c->dout + at, (size_t)n);
    }
    if (c->din[SCALE])
        c->din[SCALE][ch] += (lt_real)dscale;
    if (c->din[SHIFT])
        c->din[SHIFT][ch] += (lt_real)dshift;
}

static void backward(const lt_call *c)
{
    op_start(c, SCALE, 0, lt_dim(c->out, 1));
    op_start(c, SHIFT, 0, lt_dim(c->out, 1));
    op_by_row(c, lt_dim(c->out, 1), lt_dim(c->out, 0) * op_inner(c->out, 1), backward_channel);
}

static bool as_tail(const lt_node *node, int i, lt_tail *tail)
{
    const affine_attr *a = node->attr;

    if (i != X || a->act.kind != LT_ACT_NONE || !lt_is_constant(node->in[SCALE])
        || !lt_is_constant(node->in[SHIFT]))
        return false;
    tail->scale = node->in[SCALE];
    tail->shift = node->in[SHIFT];
    return true;
}

static bool absorb(lt_node *node, const lt_tail *tail)
{
    affine_attr *a = node->attr;

    if (tail->scale || tail->addend || a->act.kind != LT_ACT_NONE)
        return false;
    a->act = tail->act;
    return true;
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    lt_shape column = { .rank = n->in[X]->shape.rank - 1, .dim = { 1, 1, 1, 1, 1, 1 } };
    const char *y;

    column.dim[0] = lt_dim(n->in[X], 1);
    y = LT_ONNX(w, "Mul", lt_onnx_of(w, n->in[X]), lt_onnx_reshape(w, lt_onnx_of(w, n->in[SCALE]), column));
    y = LT_ONNX(w, "Add", y, lt_onnx_reshape(w, lt_onnx_of(w, n->in[SHIFT]), column));
    lt_onnx_is(w, n->outs[0], y);
}

static const lt_op channel_affine_op = {
    .name = "channel_affine", .flags = LT_OP_INPLACE | LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(SCALE),
    .infer = infer, .forward = forward, .backward = backward, .as_tail = as_tail, .absorb = absorb,
    .onnx = onnx,
};

lt_tensor *(lt_channel_affine)(lt_tensor *x, lt_tensor *scale, lt_tensor *shift)
{
    const affine_attr a = { .act = { .kind = LT_ACT_NONE } };

    return lt_apply(&channel_affine_op, &a, sizeof(a), (lt_tensor *[]){ x, scale, shift }, 3);
}
