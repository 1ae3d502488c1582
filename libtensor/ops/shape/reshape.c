/* SPDX-License-Identifier: Apache-2.0 */
/* reshape: the same values under another shape; detach: the same values without a gradient. Both are
 * views: no copy in either direction.
 */
#include "libtensor/ops/common.h"

typedef struct {
    lt_shape shape;
} reshape_attr;

static lt_status reshape_infer(lt_call *c)
{
    const reshape_attr *a = c->attr;
    char from[LT_SHAPE_TEXT], to[LT_SHAPE_TEXT];

    if (a->shape.rank < 0 || a->shape.rank > LT_MAX_RANK)
        return lt_fail(c, "%s does not become %s: want at most %d", lt_shape_text(&c->in[0]->shape, from),
                       lt_shape_text(&a->shape, to), LT_MAX_RANK);
    if (lt_shape_numel(&a->shape) != lt_numel(c->in[0]))
        return lt_fail(c, "%s does not become %s: another number of elements",
                       lt_shape_text(&c->in[0]->shape, from), lt_shape_text(&a->shape, to));
    c->out->shape = a->shape;
    c->out->dtype = c->in[0]->dtype;
    return LT_OK;
}

static lt_status detach_infer(lt_call *c)
{
    c->out->dtype = c->in[0]->dtype;
    return op_same_shape(c);
}

static void reshape_onnx(lt_onnx *w, const lt_node *n)
{
    lt_shape shape = n->outs[0]->shape;

    for (int i = 0; i < shape.rank; i++)
        shape.dim[i] = lt_onnx_dim(w, n->outs[0], i);
    lt_onnx_is(w, n->outs[0], lt_onnx_reshape(w, lt_onnx_of(w, n->in[0]), shape));
}

static const lt_op reshape_op = {
    .name = "reshape", .flags = LT_OP_VIEW, .any_type = LT_ANY_TYPE_IN(0), .infer = reshape_infer,
    .onnx = reshape_onnx,
};
static void detach_onnx(lt_onnx *w, const lt_node *n)
{
    lt_onnx_is(w, n->outs[0], lt_onnx_of(w, n->in[0]));
}

static const lt_op detach_op = {
    .name = "detach", .flags = LT_OP_VIEW | LT_OP_DETACH, .any_type = LT_ANY_TYPE_IN(0),
    .infer = detach_infer, .onnx = detach_onnx,
};

lt_tensor *(lt_reshape)(lt_tensor *x, lt_shape shape)
{
    const reshape_attr a = { .shape = shape };

    return lt_apply(&reshape_op, &a, sizeof(a), &x, 1);
}

lt_tensor *(lt_detach)(lt_tensor *x)
{
    return lt_apply(&detach_op, NULL, 0, &x, 1);
}
