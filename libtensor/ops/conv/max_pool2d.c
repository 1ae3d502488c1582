/* SPDX-License-Identifier: Apache-2.0 */
/* max_pool2d: y = the largest of each k x k window, every stride positions, padded with nothing.
 *   x (B, C, H, W)   ->   y (B, C, H', W')
 *   dx += dy at the place of the first maximum
 */
#include "libtensor/ops/common.h"

typedef struct {
    int k, stride, pad;
    bool ceil_mode;
} pool_attr;

/* The last window must start inside the map or its front padding, as in PyTorch. */
static int64_t out_size(int64_t n, const pool_attr *a)
{
    const int64_t span = n + 2 * (int64_t)a->pad - a->k;
    int64_t out = (a->ceil_mode ? lt_ceil_div(span, a->stride) : span / a->stride) + 1;

    if (a->ceil_mode && (out - 1) * a->stride >= n + a->pad)
        out--;
    return span < 0 ? 0 : out;
}

static lt_status infer(lt_call *c)
{
    const pool_attr *a = c->attr;
    const lt_tensor *x = c->in[0];

    if (lt_want_rank(c, 0, "input", 4))
        return LT_ESHAPE;
    if (a->k < 1 || a->stride < 1 || a->pad < 0 || a->pad > a->k / 2)
        return lt_fail(c, "window %d, stride %d, pad %d: want k >= 1, stride >= 1, 0 <= pad <= k / 2", a->k,
                       a->stride, a->pad);
    if (lt_dim(x, 3) && lt_dim(x, 2) > INT32_MAX / lt_dim(x, 3))
        return lt_fail(c, "a map of %lld x %lld, want less than 2^31 places", (long long)lt_dim(x, 2),
                       (long long)lt_dim(x, 3));
    if (lt_dim(x, 2) < 1 || lt_dim(x, 3) < 1 || out_size(lt_dim(x, 2), a) < 1 || out_size(lt_dim(x, 3), a) < 1)
        return lt_fail(c, "a %d x %d window does not fit a %lld x %lld map", a->k, a->k,
                       (long long)lt_dim(x, 2), (long long)lt_dim(x, 3));
    c->out->shape = LT_SHAPE(lt_dim(x, 0), lt_dim(x, 1), out_size(lt_dim(x, 2), a), out_size(lt_dim(x, 3), a));
    return LT_OK;
}

static void plan(lt_call *c)
{
    if (c->train)
        c->saved_bytes[0] = (size_t)lt_numel(c->out) * sizeof(int32_t);
}

static int64_t plane(const lt_tensor *t)
{
    return lt_dim(t, 2) * lt_dim(t, 3);
}

static void forward_plane(const lt_call *c, int64_t i)
{
    const pool_attr *a = c->attr;
    const lt_tensor *x = c->in[0], *y = c->out;
    int32_t *where = c->train ? (int32_t *)c->saved[0] + i * plane(y) : NULL;

    lt_k->maxpool((lt_real *)y->data + i * plane(y), where,
                  (const lt_real *)x->data + i * plane(x), (int)lt_dim(x, 2), (int)lt_dim(x, 3), a->k,
                  a->stride, a->pad, (int)lt_dim(y, 2), (int)lt_dim(y, 3));
}

static void forward_block(const lt_call *c, int64_t i)
{
    const pool_attr *a = c->attr;
    const lt_tensor *x = c->in[0], *y = c->out;

    lt_k->maxpool_block((lt_real *)y->data + i * plane(y) * LT_BLOCK,
                        (const lt_real *)x->data + i * plane(x) * LT_BLOCK, (int)lt_dim(x, 2), (int)lt_dim(x, 3), a->k,
                        a->stride, a->pad, (int)lt_dim(y, 2), (int)lt_dim(y, 3));
}

static void forward(const lt_call *c)
{
    if (lt_in_blocks(c->out))
        op_by_row(c, lt_dim(c->in[0], 0) * lt_dim(c->in[0], 1), 4 * LT_BLOCK * plane(c->in[0]), forward_block);
    else
        op_by_row(c, lt_dim(c->in[0], 0) * lt_dim(c->in[0], 1), 4 * plane(c->in[0]), forward_plane);
}

static void backward_plane(const lt_call *c, int64_t i)
{
    const int64_t n = plane(c->out);

    op_start(c, 0, i * plane(c->in[0]), plane(c->in[0]));
    lt_k->maxpool_grad(c->din[0] + i * plane(c->in[0]), c->dout + i * n, (const int32_t *)c->saved[0] + i * n,
                       (size_t)n);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        op_by_row(c, lt_dim(c->in[0], 0) * lt_dim(c->in[0], 1), plane(c->in[0]), backward_plane);
}

static unsigned takes_blocks(const lt_node *n)
{
    return op_fills_blocks(n->in[0]) ? LT_BLOCKS_IN(0) | LT_BLOCKS_OUT : 0;
}

/* Whether the result has the size that ONNX counts: without the rule for the last window */
static bool is_rounded(const lt_node *n, const pool_attr *a, bool up)
{
    for (int i = 2; i < 4; i++) {
        const int64_t span = lt_dim(n->in[0], i) + 2 * a->pad - a->k;

        if (lt_dim(n->outs[0], i) != (up ? lt_ceil_div(span, a->stride) : span / a->stride) + 1)
            return false;
    }
    return true;
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const pool_attr *a = n->attr;
    const bool ceil_mode = is_rounded(n, a, true);

    if (!ceil_mode && !is_rounded(n, a, false))
        lt_onnx_refuse(w, "a partial window that starts outside the map is kept there in one direction only");
    lt_onnx_same(w, n, "MaxPool");
    lt_onnx_ints(w, "kernel_shape", (int64_t[]){ a->k, a->k }, 2);
    lt_onnx_ints(w, "strides", (int64_t[]){ a->stride, a->stride }, 2);
    lt_onnx_ints(w, "pads", (int64_t[]){ a->pad, a->pad, a->pad, a->pad }, 4);
    lt_onnx_int(w, "ceil_mode", ceil_mode);
}

static const lt_op max_pool2d_op = {
    .name = "max_pool2d", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_NOTHING, .infer = infer, .plan = plan,
    .forward = forward, .backward = backward, .takes_blocks = takes_blocks, .onnx = onnx,
};

lt_tensor *(lt_max_pool2d)(lt_tensor *x, int k, int stride, int pad, bool ceil_mode)
{
    const pool_attr a = { k, stride, pad, ceil_mode };

    return lt_apply(&max_pool2d_op, &a, sizeof(a), &x, 1);
}
