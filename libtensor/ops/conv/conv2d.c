/* SPDX-License-Identifier: Apache-2.0 */
/* conv2d: y = act(conv(x gate, w) + b + addend), everywhere or in one rectangle of each image
 *   x (B, C, H, W)   w (O, C / groups, kh, kw)   b (O)   ->   y (B, O, H', W')
 *   dx += the transposed convolution of dy       dw += the correlation of x with dy       db += sum of dy
 *
 * act, addend, gate (B, C) and a second result, the mean of each map of y (B, O), are there only where an
 * inference plan fused them. A batch norm behind it folds into w and b: its scale (O) stands beside w until w
 * is packed with it, once per lt_plan_refresh. The rectangles (B, 4) are there only in lt_conv2d_within. With a table
 * of ranges x is read as 8-bit integers. x may also be what is before another convolution, whose work is done here:
 * y = act(conv(act0(conv(x, w0) + b0), w) + b + addend), the first one pointwise and the second depthwise.
 */
#include "libtensor/kernels/blocks/conv.h"
#include "libtensor/ops/conv/conv2d_pack.h"
#include "libtensor/ops/norm/norm_depthwise.h"

enum { X, W, B, ADDEND, SCALE, REGION, GATE, W0, B0, SCALE0, INPUTS };

typedef struct {
    lt_conv_opts opts;
    lt_act act, act0;
    bool packed;                /* in[W], and in[W0] if there, are as op_conv2d_pack leaves them ... */
    lt_shape window, window0;   /* ... and these were their shapes */
    lt_int8_range range;        /* how x is read as integers; scale 0: as it is */
} conv2d_attr;

static lt_shape window_of(const lt_call *c)
{
    const conv2d_attr *a = c->attr;

    return a->packed ? a->window : c->in[W]->shape;
}

static lt_conv2d_params params_of(const lt_call *c)
{
    const conv2d_attr *a = c->attr;
    const lt_tensor *x = c->in[X];
    const lt_shape w = window_of(c);
    const lt_conv_opts *o = &a->opts;
    const lt_conv2d_params p = {
        .n = lt_dim(x, 0), .c = w.dim[1] * a->opts.groups, .h = lt_dim(x, 2), .w = lt_dim(x, 3), .o = w.dim[0],
        .kh = (int)w.dim[2], .kw = (int)w.dim[3],
        .stride_h = o->stride, .stride_w = o->only_h ? 1 : o->stride, .pad_h = o->pad, .pad_w = o->only_h ? 0 : o->pad,
        .dil_h = o->dilation, .dil_w = o->only_h ? 1 : o->dilation, .groups = o->groups,
    };

    return p;
}

/* The one before it, which makes what this one reads */
static lt_conv2d_params params_before(const lt_call *c, const lt_conv2d_params *p)
{
    const conv2d_attr *a = c->attr;

    return (lt_conv2d_params){
        .n = p->n, .c = a->window0.dim[1], .h = p->h, .w = p->w, .o = p->c, .kh = 1, .kw = 1, .stride_h = 1,
        .stride_w = 1, .dil_h = 1, .dil_w = 1, .groups = 1,
    };
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
    char tx[LT_SHAPE_TEXT], tw[LT_SHAPE_TEXT];

    for (int i = 1; i < 4; i++)
        if (lt_dim(x, i) < 1 || lt_dim(w, i) < 1)
            return lt_fail(c, "input is %s, weight is %s: want channels, maps and windows that are not empty",
                           lt_shape_text(&x->shape, tx), lt_shape_text(&w->shape, tw));
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
    if (op_check_window(c, c->in[W]))
        return LT_ESHAPE;
    p = params_of(c);
    if (lt_conv2d_out_h(&p) < 1 || lt_conv2d_out_w(&p) < 1)
        return lt_fail(c, "a %d x %d window does not fit a %lld x %lld map", p.kh, p.kw, (long long)p.h,
                       (long long)p.w);
    if (c->in[REGION] && lt_want_shape(c, REGION, "region", LT_SHAPE(p.n, 4)))
        return LT_ESHAPE;
    c->out->shape = LT_SHAPE(p.n, p.o, lt_conv2d_out_h(&p), lt_conv2d_out_w(&p));
    return LT_OK;
}

/* Where the weights are not packed yet, forward does it at the start of its work. */
static size_t packing_bytes(const lt_call *c, const lt_conv2d_params *p)
{
    const conv2d_attr *a = c->attr;

    return a->packed ? 0 : (size_t)op_aligned(lt_conv2d_packed(p)) * sizeof(lt_real);
}

/* So does the gradient of x. */
static size_t data_bytes(const lt_conv2d_params *p)
{
    return (size_t)op_aligned(lt_conv2d_data_packed(p)) * sizeof(lt_real) + lt_conv2d_backward_data_work(p);
}

static bool is_int8(const lt_call *c)
{
    return ((const conv2d_attr *)c->attr)->range.scale > 0;
}

static bool in_blocks(const lt_call *c)
{
    return lt_in_blocks(c->out);
}

static bool in_rects(const lt_call *c, const lt_conv2d_params *p)
{
    return c->in[REGION] && (is_int8(c) ? lt_conv2d_int8_takes_rect(p) : lt_conv2d_takes_rect(p));
}

static size_t rects_bytes(const lt_conv2d_params *p)
{
    return (size_t)op_aligned(p->n * (int64_t)sizeof(lt_rect));
}

/* What the gradients take */
static size_t backward_bytes(const lt_call *c, const lt_conv2d_params *p)
{
    if (c->in[REGION] && lt_conv2d_stacks_rects(p))
        return rects_bytes(p) + lt_conv2d_backward_rects_work(p);
    return op_larger(lt_conv2d_weights_work(p), data_bytes(p));
}

static void plan(lt_call *c)
{
    const lt_conv2d_params p = params_of(c);

    if (is_int8(c)) {
        c->work_bytes = in_rects(c, &p) ? lt_conv2d_int8_rect_work(&p) : lt_conv2d_int8_work(&p);
        return;
    }
    if (c->in[W0]) {
        const lt_conv2d_params before = params_before(c, &p);

        c->work_bytes = lt_conv_blocks_pair_work(&before, &p);
        return;
    }
    if (in_blocks(c)) {
        c->work_bytes = lt_conv_blocks_work(&p);
        return;
    }
    c->work_bytes = packing_bytes(c, &p) + (in_rects(c, &p) ? lt_conv2d_rect_work(&p) : lt_conv2d_forward_work(&p));
    if (c->train)
        c->work_bytes = op_larger(c->work_bytes, backward_bytes(c, &p));
}

static const lt_real *data_of(const lt_call *c, int i)
{
    return c->in[i] ? c->in[i]->data : NULL;
}

/* Clipped to the map, whatever the numbers are. */
static lt_rect rect_of(const lt_call *c, const lt_conv2d_params *p, int64_t image)
{
    const lt_real *r = data_of(c, REGION) + 4 * image;
    const lt_real h = (lt_real)lt_conv2d_out_h(p), w = (lt_real)lt_conv2d_out_w(p);
    const lt_rect all = lt_conv2d_all(p), empty = { 0, 0, 0, 0 };

    if (!(r[0] < r[1] && r[2] < r[3] && r[1] > 0 && r[3] > 0 && r[0] < h && r[2] < w))
        return empty;
    return (lt_rect){
        r[0] > 0 ? (int64_t)r[0] : all.y0, r[1] < h ? (int64_t)r[1] : all.y1,
        r[2] > 0 ? (int64_t)r[2] : all.x0, r[3] < w ? (int64_t)r[3] : all.x1,
    };
}

/* Elements of an image of x, of y */
static int64_t image_in(const lt_conv2d_params *p) { return p->c * p->h * p->w; }
static int64_t image_out(const lt_conv2d_params *p) { return p->o * lt_conv2d_out_h(p) * lt_conv2d_out_w(p); }

static void forward_rects(const lt_call *c, const lt_conv2d_params *p, const lt_real *packed, void *work)
{
    const int64_t in = image_in(p), out = image_out(p);
    const conv2d_attr *a = c->attr;
    const lt_real *addend = data_of(c, ADDEND);

    if (c->goes_back)           /* what multiplies it has a gradient, 0 times whatever is there */
        memset(c->out->data, 0, (size_t)(p->n * out) * sizeof(lt_real));
    for (int64_t i = 0; i < p->n; i++) {
        const lt_rect r = rect_of(c, p, i);
        const lt_real *x = data_of(c, X) + i * in, *residual = addend ? addend + i * out : NULL;
        lt_real *y = (lt_real *)c->out->data + i * out;

        if (is_int8(c))
            lt_conv2d_int8_forward_rect(p, &a->range, r, x, packed, data_of(c, B), residual, a->act, y, work);
        else
            lt_conv2d_forward_rect(p, r, x, packed, data_of(c, B), residual, a->act, y, work);
    }
}

static void forward_pair(const lt_call *c, const lt_conv2d_params *p, const lt_conv2d_around *around)
{
    const lt_conv2d_params before = params_before(c, p);
    const lt_conv_blocks_step first = {
        &before, data_of(c, W0), { .bias = data_of(c, B0), .act = ((const conv2d_attr *)c->attr)->act0 },
    };
    const lt_conv_blocks_step second = { p, data_of(c, W), *around };

    lt_conv_blocks_pair_forward(&first, &second, data_of(c, X), c->out->data, c->work);
}

static void forward(const lt_call *c)
{
    const conv2d_attr *a = c->attr;
    const lt_conv2d_params p = params_of(c);
    const lt_real *packed = a->packed ? c->in[W]->data : c->work;
    const lt_conv2d_around around = {
        .gate = data_of(c, GATE), .bias = data_of(c, B), .residual = data_of(c, ADDEND), .act = a->act,
        .mean = c->n_out > 1 ? c->outs[1]->data : NULL,
    };
    void *work = (char *)c->work + packing_bytes(c, &p);

    if (!a->packed)
        lt_conv2d_pack(&p, c->in[W]->data, c->work);
    if (c->in[W0])
        forward_pair(c, &p, &around);
    else if (in_blocks(c))
        lt_conv_blocks_forward(&p, data_of(c, X), packed, &around, c->out->data, work);
    else if (in_rects(c, &p))
        forward_rects(c, &p, packed, work);
    else if (is_int8(c))
        lt_conv2d_int8_forward(&p, &a->range, data_of(c, X), packed, &around, c->out->data, work);
    else
        lt_conv2d_forward(&p, data_of(c, X), packed, &around, c->out->data, work);
}

static void data_gradient(const lt_call *c, const lt_conv2d_params *p)
{
    lt_conv2d_data_pack(p, c->in[W]->data, c->work);
    lt_conv2d_backward_data(p, c->dout, c->work, !c->fresh[X], c->din[X],
                            (lt_real *)c->work + op_aligned(lt_conv2d_data_packed(p)));
}

static void backward(const lt_call *c)
{
    const lt_conv2d_params p = params_of(c);

    if (c->din[X])
        data_gradient(c, &p);
    op_start(c, B, 0, p.o);
    if (c->din[W])
        lt_conv2d_backward_weights(&p, c->in[X]->data, c->dout, !c->fresh[W], c->din[W], c->work);
    if (c->din[B])
        lt_conv2d_backward_bias(&p, c->dout, c->din[B]);
}

static void backward_within(const lt_call *c)
{
    const lt_conv2d_params p = params_of(c);
    const lt_conv2d_gradients to = { c->din[X], c->din[W], c->din[B] };
    lt_rect *rects = c->work;

    if (!lt_conv2d_stacks_rects(&p)) {
        backward(c);
        return;
    }
    op_start(c, X, 0, p.n * image_in(&p));
    op_start(c, W, 0, lt_numel(c->in[W]));
    op_start(c, B, 0, p.o);
    for (int64_t i = 0; i < p.n; i++)
        rects[i] = rect_of(c, &p, i);
    lt_conv2d_backward_rects(&p, rects, data_of(c, X), data_of(c, W), c->dout, &to, (char *)c->work + rects_bytes(&p));
}

static int64_t macs(const lt_call *c)
{
    const lt_conv2d_params p = params_of(c);
    const lt_rect y = lt_conv2d_all(&p);
    const int64_t before = c->in[W0] ? p.n * p.c * p.h * p.w * ((const conv2d_attr *)c->attr)->window0.dim[1] : 0;

    return before + p.n * p.o * y.y1 * y.x1 * (p.c / p.groups) * p.kh * p.kw;
}

static const char *algorithm(const lt_call *c)
{
    static const char *const names[] = {
        [LT_CONV_DIRECT] = "direct", [LT_CONV_TILES] = "tiles", [LT_CONV_TURNED] = "turned",
        [LT_CONV_TAPWISE] = "tapwise", [LT_CONV_WINOGRAD] = "winograd", [LT_CONV_WINOGRAD2] = "winograd2",
        [LT_CONV_DEPTHWISE] = "depthwise", [LT_CONV_FEW] = "few",
    };
    const lt_conv2d_params p = params_of(c);

    if (c->in[W0])
        return "depthwise after blocks";
    if (in_blocks(c))
        return lt_conv_blocks_name(&p);
    return is_int8(c) ? "int8" : names[lt_conv2d_algorithm(&p)];
}

/* conv(x, w) s + t = conv(x, w s) + b s + t, channel by channel of the output. */
static void fold_affine(lt_node *node, lt_tensor *scale, lt_tensor *shift)
{
    lt_tensor *b = node->in[B], *s = node->in[SCALE];

    node->in[SCALE] = s ? lt_mul(s, scale) : scale;
    node->in[B] = b ? lt_add(lt_mul(b, scale), shift) : shift;
}

static lt_conv2d_params params_of_node(const lt_node *node)
{
    const lt_call c = { .attr = node->attr, .in = { node->in[X], node->in[W] } };

    return params_of(&c);
}

static bool absorb_mean(lt_node *node)
{
    const lt_conv2d_params p = params_of_node(node);

    return lt_conv2d_makes_mean(&p);
}

static bool absorb_gate(lt_node *node, lt_tensor *x, lt_tensor *gate)
{
    const lt_conv2d_params p = params_of_node(node);

    if (node->in[GATE] || !lt_conv2d_takes_gate(&p))
        return false;
    node->in[X] = x;
    node->in[GATE] = gate;
    return true;
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

/* Both in blocks, as only a later pass makes them */
static bool absorb_before(lt_node *node, const lt_node *before)
{
    conv2d_attr *a = node->attr;
    const lt_tensor *between = node->in[X];
    lt_conv2d_params first, second;

    if (before->op != node->op || !lt_in_blocks(between) || !lt_in_blocks(node->outs[0]) || before->in[ADDEND]
        || before->in[GATE] || before->in[W0])
        return false;
    first = params_of_node(before), second = params_of_node(node);
    if (!lt_conv_blocks_pair_suits(&first, &second))
        return false;
    node->in[X] = before->in[X];
    node->in[W0] = before->in[W], node->in[B0] = before->in[B], node->in[SCALE0] = before->in[SCALE];
    a->act0 = ((const conv2d_attr *)before->attr)->act;
    return true;
}

static bool absorb_before_for_training(lt_node *node, const lt_node *before)
{
    const lt_conv2d_params p = params_of_node(node);

    return !node->in[B] && op_norm_depthwise(node, before, node->in[W], &p);
}

static void pack_input(lt_node *node, int weights, int scale, const conv2d_packing *how)
{
    node->in[weights] = op_conv2d_pack(node->in[weights], node->in[scale], how);
    node->in[scale] = NULL;
}

static void prepare(lt_node *node)
{
    conv2d_attr *a = node->attr;
    const lt_call c = { .attr = a };
    conv2d_packing how = { params_of_node(node), a->range, lt_in_blocks(node->outs[0]) };

    if (!lt_is_constant(node->in[W]))
        return;
    a->window = node->in[W]->shape;
    a->packed = true;
    pack_input(node, W, SCALE, &how);
    if (!node->in[W0])
        return;
    a->window0 = node->in[W0]->shape;
    how.p = params_before(&c, &how.p);
    pack_input(node, W0, SCALE0, &how);
}

/* With constant weights, as only prepare packs them. */
static unsigned takes_blocks(const lt_node *node)
{
    const lt_conv2d_params p = params_of_node(node);

    if (!lt_is_constant(node->in[W]) || !lt_conv_blocks_takes(&p))
        return 0;
    return LT_BLOCKS_IN(ADDEND) | LT_BLOCKS_OUT | (lt_conv_blocks_reads_plain(&p) ? 0 : LT_BLOCKS_IN(X));
}

/* Hardly any outputs, or groups, go faster as they are. */
static bool takes_int8(const lt_node *node)
{
    const lt_conv2d_params p = params_of_node(node);
    const lt_conv_algorithm as_it_is = lt_conv2d_algorithm(&p);

    return lt_is_constant(node->in[W]) && as_it_is != LT_CONV_DEPTHWISE && as_it_is != LT_CONV_FEW
           && lt_conv2d_int8_suits(&p);
}

static void prepare_int8(lt_node *node, const lt_int8_range *range)
{
    ((conv2d_attr *)node->attr)->range = *range;
    prepare(node);
}

static void onnx(lt_onnx *w, const lt_node *n)
{
    const lt_conv_opts *o = &((const conv2d_attr *)n->attr)->opts;

    lt_onnx_same(w, n, "Conv");
    lt_onnx_ints(w, "strides", (int64_t[]){ o->stride, o->only_h ? 1 : o->stride }, 2);
    lt_onnx_ints(w, "pads", (int64_t[]){ o->pad, o->only_h ? 0 : o->pad, o->pad, o->only_h ? 0 : o->pad }, 4);
    lt_onnx_ints(w, "dilations", (int64_t[]){ o->dilation, o->only_h ? 1 : o->dilation }, 2);
    lt_onnx_int(w, "group", o->groups);
}

#define OPTIONAL \
    (LT_OPTIONAL_IN(B) | LT_OPTIONAL_IN(ADDEND) | LT_OPTIONAL_IN(SCALE) | LT_OPTIONAL_IN(REGION) \
     | LT_OPTIONAL_IN(GATE) | LT_OPTIONAL_IN(W0) | LT_OPTIONAL_IN(B0) | LT_OPTIONAL_IN(SCALE0))

static const lt_op conv2d_op = {
    .name = "conv2d", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(W), .optional = OPTIONAL,
    .infer = infer, .plan = plan, .forward = forward, .backward = backward, .macs = macs, .algorithm = algorithm,
    .absorb = absorb, .absorb_mean = absorb_mean, .absorb_gate = absorb_gate, .takes_blocks = takes_blocks,
    .absorb_before = absorb_before, .absorb_before_for_training = absorb_before_for_training, .prepare = prepare,
    .takes_int8 = takes_int8, .prepare_int8 = prepare_int8, .onnx = onnx,
};

static const lt_op conv2d_within_op = {
    .name = "conv2d_within", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(X) | LT_KEEP_IN(W) | LT_KEEP_IN(REGION),
    .optional = OPTIONAL, .infer = infer, .plan = plan, .forward = forward, .backward = backward_within, .macs = macs,
    .algorithm = algorithm, .absorb = absorb, .prepare = prepare, .takes_int8 = takes_int8,
    .prepare_int8 = prepare_int8,
};

static lt_tensor *record(const lt_op *op, lt_tensor *x, lt_tensor *w, lt_tensor *b, const lt_conv_opts *opts,
                         lt_tensor *region)
{
    conv2d_attr a = { .opts = opts ? *opts : (lt_conv_opts){ 0 }, .act = { .kind = LT_ACT_NONE } };

    a.opts.stride = a.opts.stride ? a.opts.stride : 1;
    a.opts.dilation = a.opts.dilation ? a.opts.dilation : 1;
    a.opts.groups = a.opts.groups ? a.opts.groups : 1;
    return lt_apply(op, &a, sizeof(a), (lt_tensor *[INPUTS]){ x, w, b, NULL, NULL, region }, INPUTS);
}

lt_tensor *(lt_conv2d)(lt_tensor *x, lt_tensor *w, lt_tensor *b, const lt_conv_opts *opts)
{
    return record(&conv2d_op, x, w, b, opts, NULL);
}

lt_tensor *(lt_conv2d_within)(lt_tensor *x, lt_tensor *w, lt_tensor *b, const lt_conv_opts *opts, lt_tensor *region)
{
    return record(&conv2d_within_op, x, w, b, opts, region);
}
