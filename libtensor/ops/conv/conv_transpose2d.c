/* SPDX-License-Identifier: Apache-2.0 */
/* conv_transpose2d: the gradient of a convolution as an op of its own       [Dumoulin and Visin 2016, section 4]
 *   x (B, C, H, W)   w (C, O, kh, kw)   b (O) or none   ->   y (B, O, H', W')
 *   y[o, s i + ki - p, s j + kj - p] sums x[c, i, j] w[c, o, ki, kj],   H' = (H - 1) s - 2 p + kh
 *
 * Seen from the convolution that reads y and writes x: forward is its data gradient, which adds to y, so y
 * starts as the bias; the gradient of x is its forward; that of w its weights' with y's gradient for input.
 * In an inference plan w may be packed, once per lt_plan_refresh.
 */
#include "libtensor/kernels/conv/conv.h"
#include "libtensor/ops/common.h"

enum { X, W, B };

typedef struct {
    int stride, pad;
    lt_act act;
    bool packed;                /* in[W] is the result of conv_transpose2d_pack ... */
    lt_shape window;            /* ... and this was its shape */
} transpose_attr;

static lt_conv2d_params params_of(const lt_call *c)
{
    const transpose_attr *a = c->attr;
    const lt_tensor *x = c->in[X];
    const lt_shape w = a->packed ? a->window : c->in[W]->shape;
    const int kh = (int)w.dim[2], kw = (int)w.dim[3];

    return (lt_conv2d_params){
        .n = lt_dim(x, 0), .c = w.dim[1], .o = lt_dim(x, 1), .kh = kh, .kw = kw,
        .h = (lt_dim(x, 2) - 1) * a->stride - 2 * (int64_t)a->pad + kh,
        .w = (lt_dim(x, 3) - 1) * a->stride - 2 * (int64_t)a->pad + kw,
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
    if (op_check_window(c, c->in[W]))
        return LT_ESHAPE;
    p = params_of(c);
    if (c->in[B] && lt_want_shape(c, B, "bias", LT_SHAPE(p.c)))
        return LT_ESHAPE;
    if (lt_dim(c->in[X], 2) < 1 || lt_dim(c->in[X], 3) < 1 || p.h < 1 || p.w < 1)
        return lt_fail(c, "nothing is left of the map: it would be %lld x %lld", (long long)p.h, (long long)p.w);
    c->out->shape = LT_SHAPE(p.n, p.c, p.h, p.w);
    return LT_OK;
}

/* Work begins with the packed weights, where they are packed on the spot. */
static size_t forward_bytes(const lt_call *c, const lt_conv2d_params *p)
{
    const transpose_attr *a = c->attr;
    const int64_t packing = a->packed ? 0 : op_aligned(lt_conv2d_data_packed(p));

    return (size_t)packing * sizeof(lt_real) + lt_conv2d_backward_data_work(p);
}

/* The gradient of x is a convolution: the packed weights, its result where that is to be added, its work. */
static size_t data_bytes(const lt_call *c, const lt_conv2d_params *p)
{
    return (size_t)(op_aligned(lt_conv2d_packed(p)) + op_aligned(lt_numel(c->in[X]))) * sizeof(lt_real)
           + lt_conv2d_forward_work(p);
}

static void plan(lt_call *c)
{
    const lt_conv2d_params p = params_of(c);

    c->work_bytes = forward_bytes(c, &p);
    if (!c->train)
        return;
    c->work_bytes = op_larger(c->work_bytes, data_bytes(c, &p));
    c->work_bytes = op_larger(c->work_bytes, lt_conv2d_weights_work(&p));
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

    lt_k->affine(y, y, 1, 0, NULL, ((const transpose_attr *)c->attr)->act, (size_t)n);
}

static void forward(const lt_call *c)
{
    const transpose_attr *a = c->attr;
    const lt_conv2d_params p = params_of(c);
    lt_real *work = c->work;

    op_by_row(c, p.n * p.c, p.h * p.w, start_plane);
    if (a->packed) {
        lt_conv2d_backward_data(&p, c->in[X]->data, c->in[W]->data, true, c->out->data, work);
    } else {
        lt_conv2d_data_pack(&p, c->in[W]->data, work);
        lt_conv2d_backward_data(&p, c->in[X]->data, work, true, c->out->data,
                                work + op_aligned(lt_conv2d_data_packed(&p)));
    }
    if (a->act.kind != LT_ACT_NONE)
        op_by_row(c, p.n * p.c, 4 * p.h * p.w, act_plane);
}

/* ---- backward ----------------------------------------------------------------------------------------- */

static lt_real *result_of(const lt_call *c)
{
    const lt_conv2d_params p = params_of(c);

    return (lt_real *)c->work + op_aligned(lt_conv2d_packed(&p));
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
                      result + op_aligned(lt_numel(c->in[X])));
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
    op_start(c, B, 0, p.c);
    if (c->din[W])
        lt_conv2d_backward_weights(&p, c->dout, c->in[X]->data, !c->fresh[W], c->din[W], c->work);
    if (c->din[B])
        op_by_row(c, p.c, p.n * p.h * p.w, add_bias_gradient);
}

static int64_t macs(const lt_call *c)
{
    const lt_conv2d_params p = params_of(c);

    return lt_numel(c->in[X]) * p.c * p.kh * p.kw;
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

/* conv_transpose2d_pack: w in the order in which forward reads it; attr is the convolution's lt_conv2d_params */
static lt_status pack_infer(lt_call *c)
{
    c->out->shape = LT_SHAPE(lt_conv2d_data_packed(c->attr));
    return LT_OK;
}

static void pack_forward(const lt_call *c)
{
    lt_conv2d_data_pack(c->attr, c->in[0]->data, c->out->data);
}

static const lt_op conv_transpose2d_pack_op = {
    .name = "conv_transpose2d_pack", .infer = pack_infer, .forward = pack_forward,
};

static void prepare(lt_node *node)
{
    const lt_call c = { .attr = node->attr, .in = { node->in[X], node->in[W] } };
    const lt_conv2d_params p = params_of(&c);
    transpose_attr *a = node->attr;

    if (!lt_is_constant(node->in[W]))
        return;
    a->window = node->in[W]->shape;
    a->packed = true;
    node->in[W] = lt_apply(&conv_transpose2d_pack_op, &p, sizeof(p), &node->in[W], 1);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const transpose_attr *a = n->attr;

    lt_onnx_same(w, n, "ConvTranspose");
    lt_onnx_ints(w, "strides", (int64_t[]){ a->stride, a->stride }, 2);
    lt_onnx_ints(w, "pads", (int64_t[]){ a->pad, a->pad, a->pad, a->pad }, 4);
}

static const lt_op conv_transpose2d_op = {
    .name = "conv_transpose2d", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(W),
    .optional = LT_OPTIONAL_IN(B),
    .infer = infer, .plan = plan, .forward = forward, .backward = backward, .macs = macs, .absorb = absorb,
    .prepare = prepare, .onnx = onnx,
};

lt_tensor *(lt_conv_transpose2d)(lt_tensor *x, lt_tensor *w, lt_tensor *b, int stride, int pad)
{
    const transpose_attr a = { .stride = stride, .pad = pad };

    return lt_apply(&conv_transpose2d_op, &a, sizeof(a), (lt_tensor *[]){ x, w, b }, 3);
}
