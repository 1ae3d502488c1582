/* SPDX-License-Identifier: Apache-2.0 */
/* conv2d: y = act(conv(x, w) + b + addend)
 *   x (B, C, H, W)   w (O, C / groups, kh, kw)   b (O)   ->   y (B, O, H', W')
 *   dx += the transposed convolution of dy       dw += the correlation of x with dy       db += sum of dy
 *
 * act and addend are there only where an inference plan fused them; a batch norm behind it folds into
 * w and b, which then are computed once per lt_plan_refresh.
 */
#include "libtensor/kernels/conv.h"
#include "libtensor/ops/common.h"

enum { X, W, B, ADDEND };

typedef struct {
    lt_conv_opts opts;
    lt_act act;
} conv2d_attr;

static lt_conv2d_params params_of(const lt_call *c)
{
    const conv2d_attr *a = c->attr;
    const lt_tensor *x = c->in[X], *w = c->in[W];
    const lt_conv2d_params p = {
        .n = lt_dim(x, 0), .c = lt_dim(x, 1), .h = lt_dim(x, 2), .w = lt_dim(x, 3), .o = lt_dim(w, 0),
        .kh = (int)lt_dim(w, 2), .kw = (int)lt_dim(w, 3),
        .stride_h = a->opts.stride, .stride_w = a->opts.stride, .pad_h = a->opts.pad, .pad_w = a->opts.pad,
        .dil_h = a->opts.dilation, .dil_w = a->opts.dilation, .groups = a->opts.groups,
    };

    return p;
}

static lt_status check_opts(lt_call *c)
{
    const lt_conv_opts *o = &((const conv2d_attr *)c->attr)->opts;

    if (o->stride < 1 || o->pad < 0 || o->dilation < 1 || o->groups < 1)
        return lt_fail(c, "stride %d, pad %d, dilation %d, groups %d: want 1, 0, 1, 1 or more", o->stride,
                       o->pad, o->dilation, o->groups);
    return LT_OK;
}

static lt_status check_channels(lt_call *c)
{
    const lt_conv_opts *o = &((const conv2d_attr *)c->attr)->opts;
    const lt_tensor *x = c->in[X], *w = c->in[W];

    if (lt_dim(x, 1) != lt_dim(w, 1) * o->groups)
        return lt_fail(c, "input has %lld channels, weight wants %lld", (long long)lt_dim(x, 1),
                       (long long)(lt_dim(w, 1) * o->groups));
    if (lt_dim(w, 0) % o->groups)
        return lt_fail(c, "%d groups do not divide %lld output channels", o->groups, (long long)lt_dim(w, 0));
    return LT_OK;
}

static lt_status infer(lt_call *c)
{
    lt_conv2d_params p;

    if (lt_want_rank(c, X, "input", 4) || lt_want_rank(c, W, "weight", 4) || check_opts(c)
        || check_channels(c))
        return LT_ESHAPE;
    if (c->in[B] && lt_want_shape(c, B, "bias", LT_SHAPE(lt_dim(c->in[W], 0))))
        return LT_ESHAPE;
    p = params_of(c);
    if (lt_conv2d_out_h(&p) < 1 || lt_conv2d_out_w(&p) < 1)
        return lt_fail(c, "a %d x %d window does not fit a %lld x %lld map", p.kh, p.kw, (long long)p.h,
                       (long long)p.w);
    c->out->shape = LT_SHAPE(p.n, p.o, lt_conv2d_out_h(&p), lt_conv2d_out_w(&p));
    return LT_OK;
}

static void plan(lt_call *c)
{
    const lt_conv2d_params p = params_of(c);

    if (c->train)
        c->work_bytes = lt_conv2d_weights_work(&p);
}

static void forward(const lt_call *c)
{
    const conv2d_attr *a = c->attr;
    const lt_conv2d_params p = params_of(c);

    lt_conv2d_forward(&p, c->in[X]->data, c->in[W]->data, c->in[B] ? c->in[B]->data : NULL,
                      c->in[ADDEND] ? c->in[ADDEND]->data : NULL, a->act, c->out->data);
}

static void backward(const lt_call *c)
{
    const lt_conv2d_params p = params_of(c);

    if (c->din[X])
        lt_conv2d_backward_data(&p, c->dout, c->in[W]->data, c->din[X]);
    if (c->din[W])
        lt_conv2d_backward_weights(&p, c->in[X]->data, c->dout, c->din[W], c->work);
    if (c->din[B])
        lt_conv2d_backward_bias(&p, c->dout, c->din[B]);
}

static int64_t macs(const lt_call *c)
{
    const lt_tensor *w = c->in[W];

    return lt_numel(c->out) * lt_dim(w, 1) * lt_dim(w, 2) * lt_dim(w, 3);
}

/* conv(x, w) s + t = conv(x, w s) + b s + t, channel by channel of the output. */
static void fold_affine(lt_node *node, lt_tensor *scale, lt_tensor *shift)
{
    lt_tensor *w = node->in[W], *b = node->in[B];

    node->in[W] = lt_mul(w, lt_reshape(scale, LT_SHAPE(lt_numel(scale), 1, 1, 1)));
    node->in[B] = b ? lt_add(lt_mul(b, scale), shift) : shift;
}

static bool absorb(lt_node *node, const lt_tail *tail)
{
    conv2d_attr *a = node->attr;

    if (a->act.kind != LT_ACT_NONE || (node->in[ADDEND] && (tail->addend || tail->scale)))
        return false;
    if (tail->scale) {
        if (!lt_is_constant(node->in[W]) || (node->in[B] && !lt_is_constant(node->in[B])))
            return false;
        fold_affine(node, tail->scale, tail->shift);
    }
    if (tail->addend)
        node->in[ADDEND] = tail->addend;
    a->act = tail->act;
    return true;
}

static const lt_op conv2d_op = {
    .name = "conv2d", .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(W),
    .optional = LT_OPTIONAL_IN(B) | LT_OPTIONAL_IN(ADDEND), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward, .macs = macs, .absorb = absorb,
};

lt_tensor *(lt_conv2d)(lt_tensor *x, lt_tensor *w, lt_tensor *b, const lt_conv_opts *opts)
{
    conv2d_attr a = { .opts = opts ? *opts : (lt_conv_opts){ 0 }, .act = { .kind = LT_ACT_NONE } };

    a.opts.stride = a.opts.stride ? a.opts.stride : 1;
    a.opts.dilation = a.opts.dilation ? a.opts.dilation : 1;
    a.opts.groups = a.opts.groups ? a.opts.groups : 1;
    return lt_apply(&conv2d_op, &a, sizeof(a), (lt_tensor *[]){ x, w, b, NULL }, 4);
}
