/* SPDX-License-Identifier: Apache-2.0 */
/* Rules of the operators that leave one number of an axis, or of several. */
#include "libtensor/io/onnx/import.h"
#include "libtensor/ops/ops.h"

/* Axes are an attribute of older sets, an input of newer ones; without them all are meant, or none if it says so. */
static unsigned reduced(onnx_call *c, int rank)
{
    const unsigned axes = onnx_axes(c, 1, rank);

    if (axes || onnx_attr_int(c, "noop_with_empty_axes", 0, 0, 1))
        return axes;
    return (1u << rank) - 1;
}

/* The sum over these axes, which stay as 1 or go, and of how many elements each number was made */
static lt_tensor *sum_over(onnx_call *c, int64_t *count)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const int rank = onnx_shape(c, 0).rank;
    const bool keep = onnx_attr_int(c, "keepdims", 1, 0, 1);
    const unsigned axes = reduced(c, rank);
    lt_shape shape = { 0 };

    *count = 1;
    if (c->status)
        return NULL;
    for (int i = 0; i < rank; i++) {
        const bool goes = axes & 1u << i;

        if (goes) {
            *count *= lt_dim(x, i);
            x = onnx_sum(x, i);
        }
        if (keep || !goes)
            shape.dim[shape.rank++] = lt_dim(x, i);
    }
    return lt_reshape(x, shape);
}

static void reduce_sum(onnx_call *c)
{
    int64_t count;

    c->out.t = sum_over(c, &count);
}

static void reduce_mean(onnx_call *c)
{
    int64_t count;
    lt_tensor *sum = sum_over(c, &count);

    c->out.t = sum ? lt_scale(sum, 1 / (double)count) : NULL;
}

const onnx_rule onnx_reduce_rules[] = {
    { "ReduceSum", 1, 2, " axes keepdims noop_with_empty_axes ", reduce_sum, ONNX_WHOLE },
    { "ReduceMean", 1, 2, " axes keepdims noop_with_empty_axes ", reduce_mean, 0 },
    { 0 },
};
