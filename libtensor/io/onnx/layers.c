/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rules of the operators with windows, weights, maps and norms.
 */
#include "libtensor/io/onnx/import.h"
#include "libtensor/ops/common.h"

#include <math.h>
#include <string.h>

/* ---- products ---------------------------------------------------------------------------------------------------- */

/* Dimensions from .. to of s */
static lt_shape part_of(const lt_shape *s, int from, int to)
{
    lt_shape part = { 0 };

    for (int i = from; i < to; i++)
        part.dim[part.rank++] = s->dim[i];
    return part;
}

/* A matrix for each of the batch's: the last two dimensions, the others one after another */
static lt_tensor *matrices(lt_tensor *x, const lt_shape *batch)
{
    lt_shape full = *batch, flat = { .rank = 3, .dim = { lt_shape_numel(batch) } };

    for (int i = 0; i < 2; i++)
        flat.dim[1 + i] = full.dim[full.rank++] = lt_dim(x, i - 2);
    return lt_reshape(lt_same_shape(&x->shape, &full) ? x : onnx_expand(x, full), flat);
}

/* The last two dimensions of each are matrices; those before them stretch. */
static lt_tensor *batched_matmul(onnx_call *c, lt_tensor *a, lt_tensor *b)
{
    const lt_shape before_a = part_of(&a->shape, 0, a->shape.rank - 2);
    const lt_shape before_b = part_of(&b->shape, 0, b->shape.rank - 2);
    const lt_shape batch = onnx_stretched(c, before_a, before_b);
    lt_shape out = batch;

    if (c->status)
        return NULL;
    out.dim[out.rank++] = lt_dim(a, -2);
    out.dim[out.rank++] = lt_dim(b, -1);
    return lt_reshape(lt_matmul(matrices(a, &batch), matrices(b, &batch)), out);
}

/* An operand of one dimension is a row on the left, a column on the right, which the result has not. */
static void matmul(onnx_call *c)
{
    lt_tensor *a = onnx_tensor(c, 0), *b = onnx_tensor(c, 1), *y;
    lt_shape out;

    if (c->status)
        return;
    if (a->shape.rank < 1 || b->shape.rank < 1) {
        onnx_fail(c, "an operand has too few dimensions");
        return;
    }
    if (b->shape.rank == 2) {
        c->out.t = lt_linear(a, lt_permute(b, (int[]){ 1, 0 }), NULL);
        return;
    }
    y = batched_matmul(c, a->shape.rank > 1 ? a : lt_reshape(a, LT_SHAPE(1, lt_dim(a, 0))),
                       b->shape.rank > 1 ? b : lt_reshape(b, LT_SHAPE(lt_dim(b, 0), 1)));
    if (!y)
        return;
    c->out.t = y;
    if (y->shape.rank < 2)              /* what a graph gives that has failed */
        return;
    out = part_of(&y->shape, 0, y->shape.rank - 2);
    if (a->shape.rank > 1)
        out.dim[out.rank++] = lt_dim(y, -2);
    if (b->shape.rank > 1)
        out.dim[out.rank++] = lt_dim(y, -1);
    c->out.t = lt_reshape(y, out);
}

/* y + beta * b, which stretches to y */
static lt_tensor *add_stretched(onnx_call *c, lt_tensor *y, lt_tensor *b, double beta)
{
    const lt_shape both = onnx_stretched(c, y->shape, b->shape);

    if (c->status == LT_OK && !lt_same_shape(&both, &y->shape))
        onnx_fail(c, "what is added does not stretch to the product");
    return c->status ? NULL : lt_add(y, beta == 1 ? b : lt_scale(b, beta));
}

static void gemm(onnx_call *c)
{
    lt_tensor *a = onnx_tensor(c, 0), *w = onnx_tensor(c, 1), *b = onnx_tensor(c, 2), *y;
    const double alpha = onnx_attr_float(c, "alpha", 1), beta = onnx_attr_float(c, "beta", 1);
    bool in_rows;

    if (c->status)
        return;
    if (a->shape.rank != 2 || w->shape.rank != 2) {
        onnx_fail(c, "an operand has not 2 dimensions");
        return;
    }
    a = onnx_attr_int(c, "transA", 0, 0, 1) ? lt_permute(a, (int[]){ 1, 0 }) : a;
    w = onnx_attr_int(c, "transB", 0, 0, 1) ? w : lt_permute(w, (int[]){ 1, 0 });
    in_rows = b && alpha == 1 && beta == 1 && lt_numel(b) == lt_dim(w, 0) && b->shape.rank >= 1
        && lt_dim(b, -1) == lt_dim(w, 0);
    if (in_rows)
        b = lt_reshape(b, LT_SHAPE(lt_dim(w, 0)));
    y = lt_linear(a, w, in_rows ? b : NULL);
    y = alpha == 1 ? y : lt_scale(y, alpha);
    c->out.t = b && !in_rows ? add_stretched(c, y, b, beta) : y;
}

/* ---- windows ----------------------------------------------------------------------------------------------------- */

/* Four borders of a map: above, left, below, right */
typedef struct {
    int64_t at[4];
} borders;

static bool are_equal(const borders *b)
{
    return b->at[0] == b->at[1] && b->at[0] == b->at[2] && b->at[0] == b->at[3];
}

static borders borders_said(onnx_call *c)
{
    int n;
    const int64_t *pads = onnx_attr_ints(c, "pads", &n);
    borders b = { { 0 } };

    if (pads && n != 4)
        onnx_fail(c, "attribute \"pads\" has %d numbers, want 4", n);
    for (int i = 0; pads && i < n && c->status == LT_OK; i++) {
        if (pads[i] < 0 || pads[i] > ONNX_MAX_SIZE)
            onnx_fail(c, "attribute \"pads\" is %jd, want 0 to %d", (intmax_t)pads[i], ONNX_MAX_SIZE);
        b.at[i] = pads[i];
    }
    return b;
}

/* Borders with which the result has as many places as the stride leaves of the map's; an odd one goes below and right,
 * or above and left. */
static borders borders_of_same(const lt_tensor *x, const int64_t *k, int stride, int dilation, bool lower)
{
    borders b = { { 0 } };

    for (int i = 0; i < 2; i++) {
        const int64_t n = lt_dim(x, 2 + i), reach = (k[i] - 1) * dilation + 1;
        const int64_t all = lt_max_i64(0, (lt_ceil_div(n, stride) - 1) * stride + reach - n);

        b.at[i + (lower ? 0 : 2)] = all - all / 2;
        b.at[i + (lower ? 2 : 0)] = all / 2;
    }
    return b;
}

/* Of a window of k[0] x k[1] on the map x */
static borders borders_of(onnx_call *c, const lt_tensor *x, const int64_t *k, int stride, int dilation)
{
    const bool upper = onnx_attr_is(c, "auto_pad", "NOTSET", "SAME_UPPER");
    const bool lower = onnx_attr_is(c, "auto_pad", "NOTSET", "SAME_LOWER");

    if (c->status == LT_OK && (upper || lower) && x->shape.rank == 4)
        return borders_of_same(x, k, stride, dilation, lower);
    if (!upper && !lower && !onnx_attr_is(c, "auto_pad", "NOTSET", "NOTSET")
        && !onnx_attr_is(c, "auto_pad", "NOTSET", "VALID"))
        onnx_fail(c, "attribute \"auto_pad\" is \"%s\"; NOTSET, VALID, SAME_UPPER, SAME_LOWER are read",
                  onnx_attr(c, "auto_pad")->text);
    return borders_said(c);
}

/* Ops of ours take one border for all sides; others are put around the map before. */
static lt_tensor *with_borders(lt_tensor *x, borders *b, double value)
{
    if (are_equal(b) || x->shape.rank != 4)
        return x;
    x = onnx_pad(x, (int64_t[]){ 0, 0, b->at[0], b->at[1] }, (int64_t[]){ 0, 0, b->at[2], b->at[3] }, ONNX_PAD_VALUE,
                 value);
    *b = (borders){ { 0 } };
    return x;
}

/* Need not be said; when it is, it is true */
static void check_kernel_shape(onnx_call *c, const lt_tensor *w)
{
    const lt_onnx_attr *k = onnx_attr(c, "kernel_shape");

    if (k && c->status == LT_OK && (w->shape.rank != 4 || k->kind != LT_ONNX_A_INTS || k->n_ints != 2
                                    || k->ints[0] != lt_dim(w, 2) || k->ints[1] != lt_dim(w, 3)))
        onnx_fail(c, "attribute \"kernel_shape\" is not the weight's");
}

/* A window of k x 1 moves along the columns one by one, whatever its stride along the rows. */
static bool is_only_h(onnx_call *c, const lt_tensor *w)
{
    int n, n_pads;
    const int64_t *stride = onnx_attr_ints(c, "strides", &n), *pads = onnx_attr_ints(c, "pads", &n_pads);

    if (c->status || w->shape.rank != 4 || lt_dim(w, 3) != 1 || (stride && (n != 2 || stride[1] != 1)))
        return false;
    return onnx_attr_is(c, "auto_pad", "NOTSET", "NOTSET")
        && (!pads || (n_pads == 4 && pads[0] == pads[2] && !pads[1] && !pads[3]));
}

/* Strides, and how far the taps are from each other: the first of two numbers, which are equal but along H alone */
static int along(onnx_call *c, const char *name, bool only_h)
{
    int n;
    const int64_t *of = only_h ? onnx_attr_ints(c, name, &n) : NULL;

    if (!of)
        return onnx_attr_equal(c, name, 2, 1, 1, ONNX_MAX_SIZE);
    if (n != 2 || of[0] < 1 || of[0] > ONNX_MAX_SIZE)
        onnx_fail(c, "attribute \"%s\": want 2 numbers, from 1 to %d", name, ONNX_MAX_SIZE);
    return c->status ? 1 : (int)of[0];
}

static void conv(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *w = onnx_tensor(c, 1), *b = onnx_tensor(c, 2);
    const bool only_h = is_only_h(c, w);
    lt_conv_opts o = {
        .stride = along(c, "strides", only_h), .dilation = along(c, "dilations", only_h),
        .groups = onnx_attr_int(c, "group", 1, 1, ONNX_MAX_SIZE), .only_h = only_h,
    };
    borders around;

    check_kernel_shape(c, w);
    if (c->status)
        return;
    around = borders_of(c, x, w->shape.dim + 2, o.stride, o.dilation);
    if (!only_h)
        x = with_borders(x, &around, 0);
    o.pad = (int)around.at[0];
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
    const bool ceil_mode = onnx_attr_int(c, "ceil_mode", 0, 0, 1);
    borders around;

    if (c->status)
        return;
    around = borders_of(c, x, (int64_t[]){ k, k }, stride, 1);
    if (ceil_mode && !are_equal(&around))
        onnx_fail(c, "attribute \"ceil_mode\" with borders that differ is not read");
    x = with_borders(x, &around, -INFINITY);
    if (c->status == LT_OK)
        c->out.t = lt_max_pool2d(x, k, stride, (int)around.at[0], ceil_mode);
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

/* How much larger each of four dimensions becomes: said, or by sizes; zeros stay where neither is known */
static void scales(onnx_call *c, const lt_tensor *x, double *s)
{
    const lt_onnx_tensor *k = onnx_has(c, 2) ? c->in[2]->constant : NULL;
    const int64_t n = k ? lt_shape_numel(&k->shape) : 0;
    const int64_t *size = NULL;
    int n_size = 0;

    if (onnx_has(c, 3))
        size = onnx_ints(c, 3, &n_size);
    for (int i = 0; n == 4 && i < 4; i++) {
        float scale;

        memcpy(&scale, (const char *)k->data + (size_t)i * sizeof(scale), sizeof(scale));
        s[i] = (double)scale;
    }
    for (int i = 0; n_size == 4 && x->shape.rank == 4 && i < 4; i++)
        s[i] = (double)size[i] / (double)lt_max_i64(1, lt_dim(x, i));
}

/* Nearest by a whole factor, given as scales 1, 1, f, f or as sizes */
static void upsample(onnx_call *c, lt_tensor *x)
{
    double s[4] = { 0 };

    scales(c, x, s);
    if (s[0] != 1 || s[1] != 1 || s[2] != s[3] || !(s[2] >= 1 && s[2] <= 1024) || s[2] != (double)(int)s[2])
        onnx_fail(c, "scales are not 1, 1 and twice a whole number");
    if (!onnx_attr_is(c, "coordinate_transformation_mode", "half_pixel", "asymmetric")
        || !onnx_attr_is(c, "nearest_mode", "round_prefer_floor", "floor"))
        onnx_fail(c, "\"nearest\" is read with \"asymmetric\" and \"floor\"");
    if (c->status == LT_OK)
        c->out.t = lt_upsample_nearest(x, (int)s[2]);
}

/* PyTorch's half pixel is another one only where one pixel is made. */
static void resize(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const bool pytorch = onnx_attr_is(c, "coordinate_transformation_mode", "half_pixel", "pytorch_half_pixel");
    double s[4] = { 0 };
    int64_t size[2];

    if (c->status)
        return;
    if (onnx_attr_is(c, "mode", "nearest", "nearest")) {
        upsample(c, x);
        return;
    }
    if (!onnx_attr_is(c, "mode", "nearest", "linear")
        || (!onnx_attr_is(c, "coordinate_transformation_mode", "half_pixel", "half_pixel") && !pytorch))
        onnx_fail(c, "\"linear\" with \"half_pixel\" or \"nearest\" is read");
    scales(c, x, s);
    if (s[0] != 1 || s[1] != 1 || x->shape.rank != 4) {
        onnx_fail(c, "want a size for the last two of four dimensions");
        return;
    }
    for (int i = 0; i < 2; i++) {
        const double exact = s[2 + i] * (double)lt_dim(x, 2 + i);

        size[i] = exact >= 0.5 && exact <= ONNX_MAX_SIZE ? llround(exact) : 0;
        if (size[i] < (pytorch ? 2 : 1) || fabs(exact - (double)size[i]) > 1e-3)
            onnx_fail(c, "a size of %g", exact);
    }
    if (c->status == LT_OK)
        c->out.t = lt_resize_bilinear(x, size[0], size[1]);
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

/* Over one axis; before set 13 over all from there on */
static void softmax(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const bool old = c->opset < 13;
    const int axis = onnx_axis(c, old ? 1 : -1), rank = onnx_shape(c, 0).rank;
    int order[LT_MAX_RANK];

    if (c->status)
        return;
    if (axis == rank - 1) {
        c->out.t = lt_softmax(x);
    } else if (old) {
        const lt_shape rest = part_of(&x->shape, axis, rank);

        c->out.t = lt_reshape(lt_softmax(lt_reshape(x, LT_SHAPE(op_outer(x, axis), lt_shape_numel(&rest)))), x->shape);
    } else {
        for (int i = 0; i < rank; i++)
            order[i] = i == axis ? rank - 1 : i == rank - 1 ? axis : i;
        c->out.t = lt_permute(lt_softmax(lt_permute(x, order)), order);
    }
}

static lt_tensor *constant_zeros(onnx_call *c, lt_shape shape)
{
    lt_tensor *t;

    lt_constant_reals(c->g, shape, &t);
    return t;
}

/* Over the dimensions from axis on */
static void layer_norm(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *weight = onnx_tensor(c, 1), *bias = onnx_tensor(c, 2);
    const int axis = onnx_axis(c, -1);
    lt_shape rest, flat;

    if (c->status)
        return;
    rest = part_of(&x->shape, axis, x->shape.rank);
    flat = LT_SHAPE(lt_shape_numel(&rest));
    if (!lt_same_shape(&weight->shape, &rest) || (bias && !lt_same_shape(&bias->shape, &rest))) {
        onnx_fail(c, "its weights are not of the shape that is normalised");
        return;
    }
    weight = lt_reshape(weight, flat);
    bias = bias ? lt_reshape(bias, flat) : constant_zeros(c, flat);
    if (c->status == LT_OK)
        c->out.t = lt_reshape(lt_layer_norm(lt_reshape(x, LT_SHAPE(op_outer(x, axis), flat.dim[0])), weight, bias,
                                            onnx_attr_float(c, "epsilon", 1e-5)), x->shape);
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
    { "Softmax", 1, 1, " axis ", softmax, 0 },
    { "MatMul", 2, 2, "", matmul, ONNX_WHOLE },
    { "Gemm", 2, 3, " alpha beta transA transB ", gemm, 0 },
    { "Conv", 2, 3, " kernel_shape strides pads dilations group auto_pad ", conv, 0 },
    { "ConvTranspose", 2, 3, " kernel_shape strides pads dilations group auto_pad=NOTSET output_padding=0 ",
      conv_transpose, 0 },
    { "GridSample", 2, 2, " mode padding_mode align_corners ", grid_sample, 0 },
    { "MaxPool", 1, 1, " kernel_shape strides pads ceil_mode auto_pad dilations=1 storage_order=0 ",
      max_pool, ONNX_WHOLE },
    { "GlobalAveragePool", 1, 1, "", global_average_pool, 0 },
    { "Resize", 1, 4, " mode coordinate_transformation_mode nearest_mode cubic_coeff_a exclude_outside=0 antialias=0 "
      "extrapolation_value keep_aspect_ratio_policy=stretch ", resize, 0 },
    { "RoiAlign", 3, 3, " mode coordinate_transformation_mode output_height output_width sampling_ratio spatial_scale ",
      roi_align, 0 },
    { "LayerNormalization", 2, 3, " axis epsilon stash_type=1 ", layer_norm, 0 },
    { "BatchNormalization", 5, 5, " epsilon momentum training_mode ", batch_norm, 0 },
    { 0 },
};
