/* SPDX-License-Identifier: Apache-2.0 */
/* global_avg_pool: y = the mean of each channel's map.
 *   x (B, C, H, W)   ->   y (B, C)
 *   dx += dy / (H W)
 */
#include "libtensor/kernels/blocks/blocks.h"
#include "libtensor/ops/common.h"

static lt_status infer(lt_call *c)
{
    if (lt_want_rank(c, 0, "input", 4))
        return LT_ESHAPE;
    if (lt_dim(c->in[0], 2) * lt_dim(c->in[0], 3) < 1)
        return lt_fail(c, "the map is empty");
    c->out->shape = LT_SHAPE(lt_dim(c->in[0], 0), lt_dim(c->in[0], 1));
    return LT_OK;
}

static int64_t plane(const lt_call *c)
{
    return lt_dim(c->in[0], 2) * lt_dim(c->in[0], 3);
}

static void forward_plane(const lt_call *c, int64_t i)
{
    const lt_real *x = (const lt_real *)c->in[0]->data + i * plane(c);

    ((lt_real *)c->out->data)[i] = (lt_real)(lt_k->sum(x, (size_t)plane(c)) / (double)plane(c));
}

static void forward(const lt_call *c)
{
    if (lt_in_blocks(c->in[0]))
        lt_blocks_mean(c->out->data, c->in[0]->data, lt_dim(c->out, 0), lt_dim(c->out, 1), plane(c));
    else
        op_by_row(c, lt_numel(c->out), plane(c), forward_plane);
}

static void backward_plane(const lt_call *c, int64_t i)
{
    const lt_real g = c->dout[i] / (lt_real)plane(c);
    lt_real *dx = c->din[0] + i * plane(c);

    op_start(c, 0, i * plane(c), plane(c));
    lt_k->affine(dx, dx, 1, g, NULL, (lt_act){ .kind = LT_ACT_NONE }, (size_t)plane(c));
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        op_by_row(c, lt_numel(c->out), plane(c), backward_plane);
}

static unsigned takes_blocks(const lt_node *node)
{
    (void)node;
    return LT_BLOCKS_IN(0);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const char *mean = LT_ONNX(w, "GlobalAveragePool", lt_onnx_of(w, n->in[0]));

    lt_onnx_is(w, n->outs[0], LT_ONNX(w, "Flatten", mean));
}

static const lt_op global_avg_pool_op = {
    .name = "global_avg_pool", .flags = LT_OP_ASSIGNS | LT_OP_CHANNEL_MEAN, .keeps = LT_KEEP_NOTHING, .infer = infer,
    .forward = forward, .backward = backward, .takes_blocks = takes_blocks, .onnx = onnx,
};

lt_tensor *(lt_global_avg_pool)(lt_tensor *x)
{
    return lt_apply(&global_avg_pool_op, NULL, 0, &x, 1);
}
