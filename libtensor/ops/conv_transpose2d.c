/* SPDX-License-Identifier: Apache-2.0 */
/* conv_transpose2d: the gradient of a convolution as an op of its own       [Dumoulin and Visin 2016, section 4]
 *   x (B, C, H, W)   w (C, O, kh, kw)   b (O) or none   ->   y (B, O, H', W')
 *   y[o, s i + ki - p, s j + kj - p] sums x[c, i, j] w[c, o, ki, kj],   H' = (H - 1) s - 2 p + kh
 *
 * Seen from the convolution that reads y and writes x: forward is its data gradient, which adds to y, so y
 * starts as the bias; the gradient of x is its forward; that of w its weights' with y's gradient for input.
 */
#include "libtensor/kernels/conv.h"
#include "libtensor/ops/common.h"

enum { X, W, B };

typedef struct {
    int stride, pad;
    lt_act act;
} transpose_attr;

static lt_conv2d_params params_of(const lt_call *c)
{
    const transpose_attr *a = c->attr;
    const lt_tensor *x = c->in[X], *w = c->in[W];
    const int kh = (int)lt_dim(w, 2), kw = (int)lt_dim(w, 3);

    return (lt_conv2d_params){
        .n = lt_dim(x, 0), .c = lt_dim(w, 1), .o = lt_dim(x, 1), .kh = kh, .kw = kw,
        .h = (lt_dim(x, 2) - 1) * a->stride - 2 * a->pad + kh, .w = (lt_dim(x, 3) - 1) * a->stride - 2 * a->pad + kw,
        .stride_h = a->stride, .stride_w = a->stride, .pad_h = a->pad, .pad_w = a->pad, .dil_h = 1, .dil_w = 1,
        .groups = 1,
    };
}

static lt_status infer(lt_call *c)
{
    const transpose_attr *a = c->attr;
    lt_conv2d_params p;

    if (lt_want_rank(c, X, "input", 4) || lt_want_rank(c, W, "weight", 4))
        return LT_ESHAPE;
    if (a->stride < 1 || a->pad < 0)
        return lt_fail(c, "stride %d, pad %d: want 1, 0 or more", a->stride, a->pad);
    if (lt_dim(c->in[X], 1) != lt_dim(c->in[W], 0))
        return lt_fail(c, "input has %lld channels, weight wants %lld", (long long)lt_dim(c->in[X], 1),
                       (long long)lt_dim(c->in[W], 0));
    p = params_of(c);
    if (c->in[B] && lt_want_shape(c, B, "bias", LT_SHAPE(p.c)))
        return LT_ESHAPE;
    if (p.kh < 1 || p.kw < 1 || (int64_t)p.kh * p.kw > LT_CONV_MOST_TAPS)
        return lt_fail(c, "a %d x %d window: want 1 to %d elements", p.kh, p.kw, LT_CONV_MOST_TAPS);
    if (lt_dim(c->in[X], 2) < 1 || lt_dim(c->in[X], 3) < 1 || p.h < 1 || p.w < 1)
        return lt_fail(c, "nothing is left of the map: it would be %lld x %lld", (long long)p.h, (long long)p.w);
    c->out->shape = LT_SHAPE(p.n, p.c, p.h, p.w);
    return LT_OK;
}

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

/* The gradient of x is a convolution. Its work: packed weights, its result where that is to be added, scratch. */
static int64_t packed_elements(const lt_conv2d_params *p)
{
    return lt_ceil_div(lt_conv2d_packed(p), LT_ALIGN) * LT_ALIGN;
}

static int64_t result_elements(const lt_call *c)
{
    return lt_ceil_div(lt_numel(c->in[X]), LT_ALIGN) * LT_ALIGN;
}

static size_t data_bytes(const lt_call *c, const lt_conv2d_params *p)
{
    return (size_t)(packed_elements(p) + result_elements(c)) * sizeof(lt_real) + lt_conv2d_forward_work(p);
}

static void plan(lt_call *c)
{
    const lt_conv2d_params p = params_of(c);

    c->work_bytes = lt_conv2d_backward_data_work(&p);
    if (!c->train)
        return;
    c->work_bytes = larger(c->work_bytes, data_bytes(c, &p));
    c->work_bytes = larger(c->work_bytes, lt_conv2d_weights_work(&p));
}

/* ---- forward ------------------------------------------------------------------------------------------ */

static void start_plane(const lt_call *c, int64_t plane)
{
    const int64_t n = op_inner(c->out, 1);
    lt_real *y = (lt_real *)c->out->data + plane * n;
    const lt_real b = c->in[B] ? ((const lt_real *)c->in[B]->data)[plane % lt_dim(c->out, 1)] : 0;

    for (int64_t i = 0; i < n; i++)
        y[i] = b;
}

static void act_plane(const lt_call *c, int64_t plane)
{
    const int64_t n = op_inner(c->out, 1);
    lt_real *y = (lt_real *)c->out->data + plane * n;

    lt_k->affine(y, y, 1, 0, ((const transpose_attr *)c->attr)->act, (size_t)n);
}

static void forward(const lt_call *c)
{
    const lt_conv2d_params p = params_of(c);

    op_by_row(c, p.n * p.c, p.h * p.w, start_plane);
    lt_conv2d_backward_data(&p, c->in[X]->data, c->in[W]->data, c->out->data, c->work);
    if (((const transpose_attr *)c->attr)->act.kind != LT_ACT_NONE)
        op_by_row(c, p.n * p.c, 4 * p.h * p.w, act_plane);
}

/* ---- backward ----------------------------------------------------------------------------------------- */

static lt_real *result_of(const lt_call *c)
{
    const lt_conv2d_params p = params_of(c);

    return (lt_real *)c->work + packed_elements(&p);
}

static void add_result(const lt_call *c, int64_t at, size_t n)
{
    lt_k->add_to(c->din[X] + at, result_of(c) + at, n);
}

static void data_gradient(const lt_call *c, const lt_conv2d_params *p)
{
    const lt_act none = { .kind = LT_ACT_NONE };
    lt_real *result = result_of(c);

    lt_conv2d_pack(p, c->in[W]->data, c->work);
    lt_conv2d_forward(p, c->dout, c->work, &(lt_conv2d_around){ .act = none }, c->fresh[X] ? c->din[X] : result,
                      result + result_elements(c));
    if (!c->fresh[X])
        op_by_chunk(c, lt_numel(c->in[X]), add_result);
}

static void add_bias_gradient(const lt_call *c, int64_t o)
{
    const int64_t O = lt_dim(c->out, 1), n = op_inner(c->out, 1);
    double sum = 0;

    for (int64_t b = 0; b < lt_dim(c->out, 0); b++)
        sum += lt_k->sum(c->dout + (b * O + o) * n, (size_t)n);
    c->din[B][o] += (lt_real)sum;
}

static void backward(const lt_call *c)
{
    const lt_conv2d_params p = params_of(c);

    if (c->din[X])
        data_gradient(c, &p);
    op_start(c, W, 0, lt_numel(c->in[W]));
    op_start(c, B, 0, p.c);
    if (c->din[W])
        lt_conv2d_backward_weights(&p, c->dout, c->in[X]->data, c->din[W], c->work);
    if (c->din[B])
        op_by_row(c, p.c, p.n * p.h * p.w, add_bias_gradient);
}

static int64_t macs(const lt_call *c)
{
    return lt_numel(c->in[X]) * op_inner(c->in[W], 0);
}

/* ---- inference: a norm and an activation behind it -------------------------------------------------------- */

static bool absorb(lt_node *node, const lt_tail *tail)
{
    transpose_attr *a = node->attr;
    lt_tensor *w = node->in[W], *b = node->in[B];

    if (a->act.kind != LT_ACT_NONE || tail->addend || (tail->scale && !lt_is_constant(w))
        || (tail->scale && b && !lt_is_constant(b)))
        return false;
    if (tail->scale) {
        node->in[W] = lt_mul(w, lt_reshape(tail->scale, LT_SHAPE(lt_dim(w, 1), 1, 1)));
        node->in[B] = b ? lt_add(lt_mul(b, tail->scale), tail->shift) : tail->shift;
    }
    a->act = tail->act;
    return true;
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const transpose_attr *a = n->attr;

    lt_onnx_same(w, n, "ConvTranspose");
    lt_onnx_ints(w, "strides", (int64_t[]){ a->stride, a->stride }, 2);
    lt_onnx_ints(w, "pads", (int64_t[]){ a->pad, a->pad, a->pad, a->pad }, 4);
}

static const lt_op conv_transpose2d_op = {
    .name = "conv_transpose2d", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(W), .optional = LT_OPTIONAL_IN(B),
    .infer = infer, .plan = plan, .forward = forward, .backward = backward, .macs = macs, .absorb = absorb,
    .onnx = onnx,
};

lt_tensor *(lt_conv_transpose2d)(lt_tensor *x, lt_tensor *w, lt_tensor *b, int stride, int pad)
{
    const transpose_attr a = { .stride = stride, .pad = pad };

    return lt_apply(&conv_transpose2d_op, &a, sizeof(a), (lt_tensor *[]){ x, w, b }, 3);
}
