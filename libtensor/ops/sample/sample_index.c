/* SPDX-License-Identifier: Apache-2.0 */
/* sample_index: the number of each sample.
 *   x (B, ...)   ->   0, 1 ... B - 1 (B, 1)
 *
 * Of x only the shape counts; there is no gradient. It is an op, and no constant, so that a graph says the
 * same for every batch.
 */
#include "libtensor/ops/common.h"

static lt_status infer(lt_call *c)
{
    if (c->in[0]->shape.rank < 1)
        return lt_fail(c, "its input has no dimension for samples");
    c->out->shape = LT_SHAPE(lt_dim(c->in[0], 0), 1);
    return LT_OK;
}

static void forward(const lt_call *c)
{
    lt_real *y = c->out->data;

    for (int64_t i = 0; i < lt_numel(c->out); i++)
        y[i] = (lt_real)i;
}

/* Range from 0 to the first number of x's shape */
static void onnx(lt_onnx *w, const lt_node *n)
{
    const char *size = LT_ONNX(w, "Shape", lt_onnx_of(w, n->in[0])), *list;

    lt_onnx_int(w, "end", 1);
    list = LT_ONNX(w, "Range", lt_onnx_index(w, 0), LT_ONNX(w, "Squeeze", size), lt_onnx_index(w, 1));
    list = LT_ONNX(w, "Cast", list);
    lt_onnx_int(w, "to", LT_ONNX_FLOAT);
    lt_onnx_is(w, n->outs[0], lt_onnx_reshape(w, list, LT_SHAPE(-1, 1)));
}

static const lt_op sample_index_op = {
    .name = "sample_index", .flags = LT_OP_DETACH, .keeps = LT_KEEP_NOTHING, .any_type = LT_ANY_TYPE_IN(0),
    .infer = infer, .forward = forward, .onnx = onnx,
};

lt_tensor *(lt_sample_index)(lt_tensor *x)
{
    return lt_apply(&sample_index_op, NULL, 0, &x, 1);
}
