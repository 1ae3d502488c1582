/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rules of the operators with windows, weights, maps and norms.
 */
#include "libtensor/io/onnx/import.h"
#include "libtensor/ops/ops.h"

#include <string.h>

/* ---- products ---------------------------------------------------------------------------------------------------- */

/* The last two dimensions of each, the others one after another */
static lt_tensor *batched_matmul(onnx_call *c, lt_tensor *a, lt_tensor *b)
{
    const int rank = a->shape.rank;
    lt_shape out = a->shape;
    int64_t outer = 1;

    if (b->shape.rank != rank) {
        onnx_fail(c, "its operands stretch, which is not read");
        return NULL;
    }
    for (int i = 0; i < rank - 2; i++) {
        if (lt_dim(a, i) != lt_dim(b, i)) {
            onnx_fail(c, "its operands stretch, which is not read");
            return NULL;
        }
        outer *= lt_dim(a, i);
    }
    out.dim[rank - 1] = lt_dim(b, -1);
    a = lt_reshape(a, LT_SHAPE(outer, lt_dim(a, -2), lt_dim(a, -1)));
    b = lt_reshape(b, LT_SHAPE(outer, lt_dim(b, -2), lt_dim(b, -1)));
    return lt_reshape(lt_matmul(a, b), out);
}

static void matmul(onnx_call *c)
{
    lt_tensor *a = onnx_tensor(c, 0), *b = onnx_tensor(c, 1);

    if (c->status)
        return;
    if (a->shape.rank < 1 || b->shape.rank < 2)
        onnx_fail(c, "an operand has too few dimensions");
    else if (b->shape.rank == 2)
        c->out.t = lt_linear(a, lt_permute(b, (int[]){ 1, 0 }), NULL);
    else
        c->out.t = batched_matmul(c, a, b);
}

static void gemm(onnx_call *c)
{
    lt_tensor *a = onnx_tensor(c, 0), *w = onnx_tensor(c, 1), *b = onnx_tensor(c, 2);

    onnx_attr_int(c, "transA", 0, 0, 0);
    if (onnx_attr_float(c, "alpha", 1) != 1 || onnx_attr_float(c, "beta", 1) != 1)
        onnx_fail(c, "alpha or beta is not 1");
    if (c->status)
        return;
    if (a->shape.rank != 2 || w->shape.rank != 2)
        onnx_fail(c, "an operand has not 2 dimensions");
    else
        c->out.t = lt_linear(a, onnx_attr_int(c, "transB", 0, 0, 1) ? w : lt_permute(w, (int[]){ 1, 0 }), b);
}

/* Need not be said; when it is, it is true */
static void check_kernel_shape(onnx_call *c, const lt_tensor *w)
{
    const lt_onnx_attr *k = onnx_attr(c, "kernel_shape");

    if (k && c->status == LT_OK && (w->shape.rank != 4 || k->kind != LT_ONNX_A_INTS || k->n_ints != 2
                                    || k->ints[0] != lt_dim(w, 2) || k->ints[1] != lt_dim(w, 3)))
        onnx_fail(c, "attribute \"kernel_shape\" is not the weight's");
}

static void conv(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *w = onnx_tensor(c, 1), *b = onnx_tensor(c, 2);
    const lt_conv_opts o = {
        .stride = onnx_attr_equal(c, "strides", 2, 1, 1, ONNX_MAX_SIZE),
        .pad = onnx_attr_equal(c, "pads", 4, 0, 0, ONNX_MAX_SIZE),
        .dilation = onnx_attr_equal(c, "dilations", 2, 1, 1, ONNX_MAX_SIZE),
        .groups = onnx_attr_int(c, "group", 1, 1, ONNX_MAX_SIZE),
    };

    check_kernel_shape(c, w);
    if (c->status == LT_OK)
        c->out.t = lt_conv2d(x, w, b, &o);
}

static void conv_transpose(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *w = onnx_tensor(c, 1), *b = onnx_tensor(c, 2);
    const int stride = onnx_attr_equal(c, "strides", 2, 1, 1, ONNX_MAX_SIZE),
        pad = onnx_attr_equal(c, "pads", 4, 0, 0, ONNX_MAX_SIZE);

    onnx_attr_int(c, "group", 1, 1, 1);
    onnx_attr_equal(c, "dilations", 2, 1, 1, 1);
    check_kernel_shape(c, w);
    if (c->status == LT_OK)
        c->out.t = lt_conv_transpose2d(x, w, b, stride, pad);
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

static void max_pool(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const int k = onnx_attr_equal(c, "kernel_shape", 2, 0, 1, ONNX_MAX_SIZE);
    const int stride = onnx_attr_equal(c, "strides", 2, 1, 1, ONNX_MAX_SIZE);
    const int pad = onnx_attr_equal(c, "pads", 4, 0, 0, ONNX_MAX_SIZE);
    const bool ceil_mode = onnx_attr_int(c, "ceil_mode", 0, 0, 1);

    if (c->status == LT_OK)
        c->out.t = lt_max_pool2d(x, k, stride, pad, ceil_mode);
}

static void global_average_pool(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);

    if (c->status)
        return;
    if (x->shape.rank != 4)
        onnx_fail(c, "its input has %d dimensions, want 4", x->shape.rank);
    else
        c->out.t = lt_reshape(lt_global_avg_pool(x), LT_SHAPE(lt_dim(x, 0), lt_dim(x, 1), 1, 1));
}

/* Nearest by a whole factor, given as scales 1, 1, f, f */
static void upsample(onnx_call *c, lt_tensor *x)
{
    const lt_onnx_tensor *k = c->n_in > 2 && c->in[2] ? c->in[2]->constant : NULL;
    float s[4] = { 0 };

    if (k && lt_shape_numel(&k->shape) == 4)
        memcpy(s, k->data, sizeof(s));
    if (s[0] != 1 || s[1] != 1 || s[2] != s[3] || !(s[2] >= 1 && s[2] <= 1024) || s[2] != (float)(int)s[2])
        onnx_fail(c, "scales are not 1, 1 and twice a whole number");
    if (!onnx_attr_is(c, "coordinate_transformation_mode", "half_pixel", "asymmetric")
        || !onnx_attr_is(c, "nearest_mode", "round_prefer_floor", "floor"))
        onnx_fail(c, "\"nearest\" is read with \"asymmetric\" and \"floor\"");
    if (c->status == LT_OK)
        c->out.t = lt_upsample_nearest(x, (int)s[2]);
}

static void resize(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const int64_t *size;
    int n;

    if (c->status)
        return;
    if (onnx_attr_is(c, "mode", "nearest", "nearest")) {
        upsample(c, x);
        return;
    }
    if (!onnx_attr_is(c, "mode", "nearest", "linear")
        || !onnx_attr_is(c, "coordinate_transformation_mode", "half_pixel", "half_pixel"))
        onnx_fail(c, "\"linear\" with \"half_pixel\" or \"nearest\" is read");
    size = onnx_ints(c, 3, &n);
    if (n != 4 || x->shape.rank != 4 || size[0] != lt_dim(x, 0) || size[1] != lt_dim(x, 1))
        onnx_fail(c, "want a size for the last two of four dimensions");
    if (c->status == LT_OK)
        c->out.t = lt_resize_bilinear(x, size[2], size[3]);
}

static void grid_sample(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *grid = onnx_tensor(c, 1);

    onnx_attr_int(c, "align_corners", 0, 0, 0);
    if ((!onnx_attr_is(c, "mode", "bilinear", "bilinear") && !onnx_attr_is(c, "mode", "linear", "linear"))
        || !onnx_attr_is(c, "padding_mode", "zeros", "zeros"))
        onnx_fail(c, "\"bilinear\" with \"zeros\" is read");
    if (c->status == LT_OK)
        c->out.t = lt_grid_sample(x, grid);
}

static lt_tensor *image_column(onnx_call *c)
{
    const lt_shape s = onnx_shape(c, 2);

    if (s.rank != 1) {
        onnx_fail(c, "images' indices are no list");
        return NULL;
    }
    if (!onnx_is_known(c, 2))
        return c->in[2]->whole ? lt_reshape(onnx_tensor(c, 2), LT_SHAPE(s.dim[0], 1)) : NULL;
    return onnx_reals(c, 2, LT_SHAPE(s.dim[0], 1));
}

static void roi_align(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *boxes = onnx_tensor(c, 1), *image = image_column(c);
    const int out_h = onnx_attr_int(c, "output_height", 1, 1, ONNX_MAX_SIZE);
    const int out_w = onnx_attr_int(c, "output_width", 1, 1, ONNX_MAX_SIZE);
    const char *usual = c->opset < 16 ? "output_half_pixel" : "half_pixel";

    onnx_attr_int(c, "sampling_ratio", 0, 0, 0);
    if (!onnx_attr_is(c, "mode", "avg", "avg")
        || !onnx_attr_is(c, "coordinate_transformation_mode", usual, "output_half_pixel"))
        onnx_fail(c, "\"avg\" with \"output_half_pixel\" is read");
    if (!image)
        onnx_fail(c, "images' indices are no whole numbers");
    if (c->status == LT_OK)
        c->out.t = lt_roi_align(x, lt_concat((lt_tensor *[]){ image, boxes }, 2, 1), out_h, out_w,
                                onnx_attr_float(c, "spatial_scale", 1));
}

/* ---- normalisation ----------------------------------------------------------------------------------------------- */

static void softmax(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const int axis = onnx_axis(c, -1);

    if (axis != onnx_shape(c, 0).rank - 1)
        onnx_fail(c, "over axis %d; over the last one is read", axis);
    if (c->status == LT_OK)
        c->out.t = lt_softmax(x);
}

static void layer_norm(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *weight = onnx_tensor(c, 1), *bias = onnx_tensor(c, 2);

    if (onnx_axis(c, -1) != onnx_shape(c, 0).rank - 1)
        onnx_fail(c, "over other dimensions than the last one");
    if (c->status == LT_OK)
        c->out.t = lt_layer_norm(x, weight, bias, onnx_attr_float(c, "epsilon", 1e-5));
}

static void batch_norm(onnx_call *c)
{
    lt_tensor *in[5];

    onnx_attr_int(c, "training_mode", 0, 0, 0);
    for (int i = 0; i < 5; i++)
        in[i] = onnx_tensor(c, i);
    if (c->status == LT_OK)
        c->out.t = lt_batch_norm(in[0], in[1], in[2], in[3], in[4], onnx_attr_float(c, "epsilon", 1e-5));
}

const onnx_rule onnx_layer_rules[] = {
    { "Softmax", 1, 1, " axis ", softmax, false },
    { "MatMul", 2, 2, "", matmul, true },
    { "Gemm", 2, 3, " alpha beta transA transB ", gemm, false },
    { "Conv", 2, 3, " kernel_shape strides pads dilations group ", conv, false },
    { "ConvTranspose", 2, 3, " kernel_shape strides pads dilations group ", conv_transpose, false },
    { "GridSample", 2, 2, " mode padding_mode align_corners ", grid_sample, false },
    { "MaxPool", 1, 1, " kernel_shape strides pads ceil_mode ", max_pool, true },
    { "GlobalAveragePool", 1, 1, "", global_average_pool, false },
    { "Resize", 1, 4, " mode coordinate_transformation_mode nearest_mode ", resize, false },
    { "RoiAlign", 3, 3, " mode coordinate_transformation_mode output_height output_width sampling_ratio spatial_scale ",
      roi_align, false },
    { "LayerNormalization", 3, 3, " axis epsilon ", layer_norm, false },
    { "BatchNormalization", 5, 5, " epsilon momentum training_mode ", batch_norm, false },
    { 0 },
};
