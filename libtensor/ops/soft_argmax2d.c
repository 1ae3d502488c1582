/* SPDX-License-Identifier: Apache-2.0 */
/* soft_argmax2d: the expected place of heat maps that sum to 1.
 *   h (B, J, H, W)   ->   (u, v) (B, J, 2), u = sum h (col + 0.5) / W, v = sum h (row + 0.5) / H
 *   dh += du (col + 0.5) / W + dv (row + 0.5) / H
 */
#include "libtensor/ops/common.h"

static lt_status infer(lt_call *c)
{
    if (lt_want_rank(c, 0, "heat maps", 4))
        return LT_ESHAPE;
    c->out->shape = LT_SHAPE(lt_dim(c->in[0], 0), lt_dim(c->in[0], 1), 2);
    return LT_OK;
}

static void forward_map(const lt_call *c, int64_t i)
{
    const int64_t H = lt_dim(c->in[0], 2), W = lt_dim(c->in[0], 3);
    const lt_real *h = (const lt_real *)c->in[0]->data + i * H * W;
    double u = 0, v = 0;

    for (int64_t r = 0; r < H; r++)
        for (int64_t k = 0; k < W; k++) {
            u += h[r * W + k] * ((double)k + 0.5);
            v += h[r * W + k] * ((double)r + 0.5);
        }
    ((lt_real *)c->out->data)[2 * i] = (lt_real)(u / (double)W);
    ((lt_real *)c->out->data)[2 * i + 1] = (lt_real)(v / (double)H);
}

static void backward_map(const lt_call *c, int64_t i)
{
    const int64_t H = lt_dim(c->in[0], 2), W = lt_dim(c->in[0], 3);
    const lt_real du = c->dout[2 * i] / (lt_real)W, dv = c->dout[2 * i + 1] / (lt_real)H;
    lt_real *dh = c->din[0] + i * H * W;

    op_start(c, 0, i * H * W, H * W);
    for (int64_t r = 0; r < H; r++)
        for (int64_t k = 0; k < W; k++)
            dh[r * W + k] += du * ((lt_real)k + (lt_real)0.5) + dv * ((lt_real)r + (lt_real)0.5);
}

static void by_map(const lt_call *c, op_row_fn fn)
{
    op_by_row(c, op_outer(c->in[0], 2), lt_dim(c->in[0], 2) * lt_dim(c->in[0], 3), fn);
}

static void forward(const lt_call *c)
{
    by_map(c, forward_map);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        by_map(c, backward_map);
}

static const lt_op soft_argmax2d_op = {
    .name = "soft_argmax2d", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = infer,
    .forward = forward, .backward = backward,
};

lt_tensor *(lt_soft_argmax2d)(lt_tensor *heat)
{
    return lt_apply(&soft_argmax2d_op, NULL, 0, &heat, 1);
}
