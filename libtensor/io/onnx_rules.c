/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What each ONNX operator is in our ops. A rule takes what docs/onnx.md lists and refuses the rest, so that
 * a model is recorded as it is meant or not at all.
 *
 * Source: onnx/onnx, docs/Operators.md.
 */
#include "libtensor/base/arena.h"
#include "libtensor/io/onnx_import.h"
#include "libtensor/ops/ops.h"

#include <string.h>

enum { MAX_SIZE = 1 << 20 };            /* of a window, a map, a range: larger is not meant */

/* ---- element by element -------------------------------------------------------------------------------------------- */

static void unary(onnx_call *c, lt_tensor *(*op)(lt_tensor *x))
{
    lt_tensor *x = onnx_tensor(c, 0);

    c->out.t = x ? op(x) : NULL;
}

static void binary(onnx_call *c, lt_tensor *(*op)(lt_tensor *a, lt_tensor *b))
{
    lt_tensor *a = onnx_tensor(c, 0), *b = onnx_tensor(c, 1);

    c->out.t = a && b ? op(a, b) : NULL;
}

static void relu(onnx_call *c) { unary(c, lt_relu); }
static void sigmoid(onnx_call *c) { unary(c, lt_sigmoid); }
static void tangent(onnx_call *c) { unary(c, lt_tanh); }
static void error_function(onnx_call *c) { unary(c, onnx_erf); }
static void square_root(onnx_call *c) { unary(c, onnx_sqrt); }
static void add(onnx_call *c) { binary(c, lt_add); }
static void subtract(onnx_call *c) { binary(c, lt_sub); }
static void multiply(onnx_call *c) { binary(c, lt_mul); }
static void divide(onnx_call *c) { binary(c, onnx_div); }
static void larger(onnx_call *c) { binary(c, onnx_max); }

static void leaky_relu(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);

    c->out.t = x ? lt_leaky_relu(x, onnx_attr_float(c, "alpha", 0.01)) : NULL;
}

static void elu(onnx_call *c)
{
    if (onnx_attr_float(c, "alpha", 1) != 1)
        onnx_fail(c, "attribute \"alpha\" is not 1");
    unary(c, lt_elu);
}

/* ---- shapes ------------------------------------------------------------------------------------------------------------ */

/* A result of its own: the same values under another shape, tensor or known numbers */
static void view(onnx_call *c, lt_shape shape)
{
    const lt_shape from = onnx_shape(c, 0);
    int n;

    if (c->status)
        return;
    if (lt_shape_numel(&shape) != lt_shape_numel(&from)) {
        onnx_fail(c, "the new shape has %jd elements, want %jd", (intmax_t)lt_shape_numel(&shape),
                  (intmax_t)lt_shape_numel(&from));
    } else if (onnx_is_known(c, 0)) {
        c->out.ints = onnx_ints(c, 0, &n);
        c->out.shape = shape;
    } else {
        lt_tensor *x = onnx_tensor(c, 0);

        c->out.t = x ? lt_reshape(x, shape) : NULL;
        c->out.whole = c->in[0]->whole;
    }
}

static void identity(onnx_call *c)
{
    view(c, onnx_shape(c, 0));
}

/* The dimension that was left open is what remains of n elements. */
static void close_shape(onnx_call *c, lt_shape *shape, int64_t n)
{
    int64_t known = 1;
    int open = -1;

    for (int i = 0; i < shape->rank; i++) {
        if (shape->dim[i] < -1 || (shape->dim[i] == -1 && open >= 0) || shape->dim[i] > INT32_MAX)
            onnx_fail(c, "the new shape cannot be");
        else if (shape->dim[i] == -1)
            open = i;
        else if (!lt_size_mul((size_t)known, (size_t)shape->dim[i], (size_t *)&known) || known < 0)
            onnx_fail(c, "the new shape cannot be");
    }
    if (c->status || open < 0)
        return;
    if (known == 0 || n % known)
        onnx_fail(c, "%jd elements do not fill the new shape", (intmax_t)n);
    else
        shape->dim[open] = n / known;
}

static void reshape(onnx_call *c)
{
    const lt_shape from = onnx_shape(c, 0);
    lt_shape to = { 0 };
    const int64_t *dim = onnx_ints(c, 1, &to.rank);

    if (to.rank > LT_MAX_RANK) {
        onnx_fail(c, "%d dimensions, at most %d are possible", to.rank, LT_MAX_RANK);
        return;
    }
    for (int i = 0; i < to.rank; i++)
        to.dim[i] = dim[i] == 0 && i < from.rank ? from.dim[i] : dim[i];
    close_shape(c, &to, lt_shape_numel(&from));
    view(c, to);
}

static void flatten(onnx_call *c)
{
    const lt_shape from = onnx_shape(c, 0);
    lt_shape to = { .rank = 2, .dim = { from.rank ? from.dim[0] : 1, 1 } };

    onnx_attr_int(c, "axis", 1, 1, 1);
    for (int i = 1; i < from.rank; i++)
        to.dim[1] *= from.dim[i];
    view(c, to);
}

static void squeeze(onnx_call *c)
{
    const lt_shape from = onnx_shape(c, 0);
    lt_shape to = { 0 };

    for (int i = 0; i < from.rank; i++)
        if (from.dim[i] != 1)
            to.dim[to.rank++] = from.dim[i];
    view(c, to);
}

static void transpose(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const lt_onnx_attr *perm = onnx_attr(c, "perm");
    int order[LT_MAX_RANK];

    if (!x)
        return;
    if (perm && (perm->kind != LT_ONNX_A_INTS || perm->n_ints != x->shape.rank)) {
        onnx_fail(c, "attribute \"perm\" is no list of %d dimensions", x->shape.rank);
        return;
    }
    for (int i = 0; i < x->shape.rank; i++) {
        const int64_t from = perm ? perm->ints[i] : x->shape.rank - 1 - i;

        order[i] = from >= 0 && from < LT_MAX_RANK ? (int)from : -1;
    }
    c->out.t = lt_permute(x, order);
}

static int axis_of(onnx_call *c, int64_t fallback)
{
    const int rank = onnx_shape(c, 0).rank, axis = onnx_attr_int(c, "axis", fallback, -rank, rank - 1);

    return axis < 0 ? axis + rank : axis;
}

static void concat_known(onnx_call *c)
{
    int64_t *all;
    int n = 0, m;

    for (int i = 0; i < c->n_in; i++) {
        onnx_ints(c, i, &m);
        n += onnx_shape(c, i).rank == 1 ? m : 0;
    }
    all = lt_arena_array(c->arena, (size_t)n, sizeof(*all));
    if (!all) {
        onnx_fail(c, "no memory");
        return;
    }
    c->out.ints = all;
    c->out.shape = LT_SHAPE(n);
    for (int i = 0; i < c->n_in; i++) {
        const int64_t *part = onnx_ints(c, i, &m);

        if (onnx_shape(c, i).rank != 1)
            onnx_fail(c, "input %d is no list", i);
        for (int k = 0; k < m && !c->status; k++)
            *all++ = part[k];
    }
}

static void concat(onnx_call *c)
{
    lt_tensor *x[ONNX_MAX_IN];
    const int axis = axis_of(c, 0);

    if (onnx_is_known(c, 0)) {
        concat_known(c);
        return;
    }
    for (int i = 0; i < c->n_in; i++)
        x[i] = onnx_tensor(c, i);
    if (c->status == LT_OK)
        c->out.t = lt_concat(x, c->n_in, axis);
}

/* One axis from start to end; places below 0 count from the end, those outside are moved to the border */
static lt_tensor *slice_axis(onnx_call *c, lt_tensor *x, int64_t axis, int64_t start, int64_t end)
{
    const int64_t rank = x->shape.rank;
    int64_t n;

    axis = axis < 0 ? axis + rank : axis;
    if (axis < 0 || axis >= rank) {
        onnx_fail(c, "axis %jd of %jd dimensions", (intmax_t)axis, (intmax_t)rank);
        return x;
    }
    n = lt_dim(x, (int)axis);
    start = lt_max_i64(0, lt_min_i64(n, start < 0 ? start + n : start));
    end = lt_max_i64(start, lt_min_i64(n, end < 0 ? end + n : end));
    return lt_slice(x, (int)axis, start, end - start);
}

static void slice(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    int n, n_end, n_axis = 0;
    const int64_t *start = onnx_ints(c, 1, &n), *end = onnx_ints(c, 2, &n_end);
    const int64_t *axis = c->n_in > 3 && c->in[3] ? onnx_ints(c, 3, &n_axis) : NULL;

    if (n != n_end || (axis && n != n_axis) || n > LT_MAX_RANK || n == 0)
        onnx_fail(c, "%d starts and %d ends", n, n_end);
    for (int i = 0; i < n && x && c->status == LT_OK; i++)
        x = slice_axis(c, x, axis ? axis[i] : i, start[i], end[i]);
    c->out.t = x;
}

static void gather(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const int axis = axis_of(c, 0);
    int n;
    const int64_t *index = onnx_ints(c, 1, &n);
    int32_t *places = lt_alloc((size_t)n * sizeof(*places));

    for (int i = 0; places && x && c->status == LT_OK && i < n; i++) {
        const int64_t size = lt_dim(x, axis), at = index[i] < 0 ? index[i] + size : index[i];

        if (at < 0 || at >= size || at > INT32_MAX)
            onnx_fail(c, "index %jd of %jd elements", (intmax_t)index[i], (intmax_t)size);
        places[i] = (int32_t)at;
    }
    if (onnx_shape(c, 1).rank != 1)
        onnx_fail(c, "the indices are no list");
    if (places && x && c->status == LT_OK)
        c->out.t = onnx_gather(x, lt_constant(c->g, LT_I32, LT_SHAPE(n), places), axis);
    lt_release(places);
}

static void shape_of(onnx_call *c)
{
    const lt_shape s = onnx_shape(c, 0);
    int start = onnx_attr_int(c, "start", 0, -s.rank, s.rank), end = onnx_attr_int(c, "end", s.rank, -s.rank, s.rank);
    int64_t *dim = lt_arena_array(c->arena, LT_MAX_RANK, sizeof(*dim));

    if (!dim) {
        onnx_fail(c, "no memory");
        return;
    }
    start += start < 0 ? s.rank : 0;
    end += end < 0 ? s.rank : 0;
    for (int i = start; i < end; i++)
        dim[i - start] = s.dim[i];
    c->out.ints = dim;
    c->out.shape = LT_SHAPE(end > start ? end - start : 0);
}

static void range(onnx_call *c)
{
    int64_t from_to_by[3] = { 0, 0, 1 }, n, *list;

    for (int i = 0; i < 3; i++) {
        int count;
        const int64_t *x = onnx_ints(c, i, &count);

        if (count != 1)
            onnx_fail(c, "input %d is not one number", i);
        else
            from_to_by[i] = x[0];
    }
    n = from_to_by[1];
    if (from_to_by[0] != 0 || from_to_by[2] != 1 || n < 0 || n > MAX_SIZE) {
        onnx_fail(c, "from %jd to %jd by %jd; from 0 to %d at most by 1 is read", (intmax_t)from_to_by[0], (intmax_t)n,
                  (intmax_t)from_to_by[2], MAX_SIZE);
        return;
    }
    list = lt_arena_array(c->arena, (size_t)n, sizeof(*list));
    for (int64_t i = 0; list && i < n; i++)
        list[i] = i;
    c->out.ints = list;
    c->out.shape = LT_SHAPE(n);
}

/* Known numbers become constants; reals made whole are cut off, and remembered as such. */
static void cast(onnx_call *c)
{
    const int to = onnx_attr_int(c, "to", 0, 1, INT32_MAX);
    const lt_shape s = onnx_shape(c, 0);
    int n;

    if (to != LT_ONNX_FLOAT && to != LT_ONNX_INT64 && to != LT_ONNX_INT32)
        onnx_fail(c, "to type %d; 1 (FLOAT), 6 (INT32), 7 (INT64) are read", to);
    if (onnx_is_known(c, 0) && to == LT_ONNX_FLOAT) {
        const int64_t *x = onnx_ints(c, 0, &n);
        lt_real *y = lt_alloc((size_t)n * sizeof(*y));

        for (int i = 0; y && i < n; i++)
            y[i] = (lt_real)x[i];
        c->out.t = y ? lt_constant(c->g, LT_F32, s, y) : NULL;
        lt_release(y);
    } else if (onnx_is_known(c, 0)) {
        view(c, s);
    } else if (onnx_tensor(c, 0)) {
        c->out.t = to == LT_ONNX_FLOAT ? lt_reshape(onnx_tensor(c, 0), s) : onnx_trunc(onnx_tensor(c, 0));
        c->out.whole = to != LT_ONNX_FLOAT;
    }
}

static void reduce_sum(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const int keep = onnx_attr_int(c, "keepdims", 1, 0, 1), rank = x ? x->shape.rank : 0;
    int n;
    const int64_t *axis = onnx_ints(c, 1, &n);
    lt_shape shape = { 0 };

    onnx_attr_int(c, "noop_with_empty_axes", 0, 0, 0);
    if (n != 1 || axis[0] < -rank || axis[0] >= rank)
        onnx_fail(c, "want one axis of the input's");
    if (!x || c->status)
        return;
    x = onnx_sum(x, (int)(axis[0] < 0 ? axis[0] + rank : axis[0]));
    for (int i = 0; i < x->shape.rank; i++)
        if (keep || i != (axis[0] < 0 ? axis[0] + rank : axis[0]))
            shape.dim[shape.rank++] = lt_dim(x, i);
    c->out.t = lt_reshape(x, shape);
}

/* ---- products ------------------------------------------------------------------------------------------------------------ */

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

    if (!a || !b)
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
    if (!a || !w)
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

    if (k && w && (w->shape.rank != 4 || k->kind != LT_ONNX_A_INTS || k->n_ints != 2 || k->ints[0] != lt_dim(w, 2)
                   || k->ints[1] != lt_dim(w, 3)))
        onnx_fail(c, "attribute \"kernel_shape\" is not the weight's");
}

static void conv(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *w = onnx_tensor(c, 1), *b = onnx_tensor(c, 2);
    const lt_conv_opts o = {
        .stride = onnx_attr_equal(c, "strides", 2, 1, 1, MAX_SIZE), .pad = onnx_attr_equal(c, "pads", 4, 0, 0, MAX_SIZE),
        .dilation = onnx_attr_equal(c, "dilations", 2, 1, 1, MAX_SIZE),
        .groups = onnx_attr_int(c, "group", 1, 1, MAX_SIZE),
    };

    check_kernel_shape(c, w);
    if (x && w && c->status == LT_OK)
        c->out.t = lt_conv2d(x, w, b, &o);
}

static void conv_transpose(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *w = onnx_tensor(c, 1), *b = onnx_tensor(c, 2);
    const int stride = onnx_attr_equal(c, "strides", 2, 1, 1, MAX_SIZE), pad = onnx_attr_equal(c, "pads", 4, 0, 0, MAX_SIZE);

    onnx_attr_int(c, "group", 1, 1, 1);
    onnx_attr_equal(c, "dilations", 2, 1, 1, 1);
    check_kernel_shape(c, w);
    if (x && w && c->status == LT_OK)
        c->out.t = lt_conv_transpose2d(x, w, b, stride, pad);
}

/* ---- maps ------------------------------------------------------------------------------------------------------------------ */

static void max_pool(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const int k = onnx_attr_equal(c, "kernel_shape", 2, 0, 1, MAX_SIZE);
    const int stride = onnx_attr_equal(c, "strides", 2, 1, 1, MAX_SIZE);
    const int pad = onnx_attr_equal(c, "pads", 4, 0, 0, MAX_SIZE);
    const bool ceil_mode = onnx_attr_int(c, "ceil_mode", 0, 0, 1);

    if (x && c->status == LT_OK)
        c->out.t = lt_max_pool2d(x, k, stride, pad, ceil_mode);
}

static void global_average_pool(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);

    if (!x)
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

    if (!x)
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
    onnx_attr_int(c, "align_corners", 0, 0, 0);
    if ((!onnx_attr_is(c, "mode", "bilinear", "bilinear") && !onnx_attr_is(c, "mode", "linear", "linear"))
        || !onnx_attr_is(c, "padding_mode", "zeros", "zeros"))
        onnx_fail(c, "\"bilinear\" with \"zeros\" is read");
    if (c->status == LT_OK)
        binary(c, lt_grid_sample);
}

static lt_tensor *image_column(onnx_call *c)
{
    const lt_shape s = onnx_shape(c, 2);
    const int64_t *known;
    lt_real *column;
    lt_tensor *t;
    int n;

    if (s.rank != 1) {
        onnx_fail(c, "images' indices are no list");
        return NULL;
    }
    if (!onnx_is_known(c, 2))
        return c->in[2] && c->in[2]->whole ? lt_reshape(onnx_tensor(c, 2), LT_SHAPE(s.dim[0], 1)) : NULL;
    known = onnx_ints(c, 2, &n);
    column = lt_alloc((size_t)n * sizeof(*column));
    for (int i = 0; column && i < n; i++)
        column[i] = (lt_real)known[i];
    t = column ? lt_constant(c->g, LT_F32, LT_SHAPE(n, 1), column) : NULL;
    lt_release(column);
    return t;
}

static void roi_align(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *boxes = onnx_tensor(c, 1), *image = image_column(c);
    const int out_h = onnx_attr_int(c, "output_height", 1, 1, MAX_SIZE);
    const int out_w = onnx_attr_int(c, "output_width", 1, 1, MAX_SIZE);

    onnx_attr_int(c, "sampling_ratio", 0, 0, 0);
    if (!onnx_attr_is(c, "mode", "avg", "avg")
        || !onnx_attr_is(c, "coordinate_transformation_mode", "half_pixel", "output_half_pixel"))
        onnx_fail(c, "\"avg\" with \"output_half_pixel\" is read");
    if (!image)
        onnx_fail(c, "images' indices are no whole numbers");
    if (x && boxes && c->status == LT_OK)
        c->out.t = lt_roi_align(x, lt_concat((lt_tensor *[]){ image, boxes }, 2, 1), out_h, out_w,
                                onnx_attr_float(c, "spatial_scale", 1));
}

/* ---- normalisation ------------------------------------------------------------------------------------------------------- */

static void softmax(onnx_call *c)
{
    const int axis = axis_of(c, -1);

    if (axis != onnx_shape(c, 0).rank - 1)
        onnx_fail(c, "over axis %d; over the last one is read", axis);
    unary(c, lt_softmax);
}

static void layer_norm(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *weight = onnx_tensor(c, 1), *bias = onnx_tensor(c, 2);

    if (axis_of(c, -1) != onnx_shape(c, 0).rank - 1)
        onnx_fail(c, "over other dimensions than the last one");
    if (x && weight && bias && c->status == LT_OK)
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

/* ---- the table -------------------------------------------------------------------------------------------------------------- */

static const onnx_rule rules[] = {
    { "Add", 2, 2, "", add }, { "Sub", 2, 2, "", subtract }, { "Mul", 2, 2, "", multiply }, { "Div", 2, 2, "", divide },
    { "Max", 2, 2, "", larger }, { "Sqrt", 1, 1, "", square_root }, { "Erf", 1, 1, "", error_function },
    { "Relu", 1, 1, "", relu }, { "LeakyRelu", 1, 1, " alpha ", leaky_relu }, { "Elu", 1, 1, " alpha ", elu },
    { "Sigmoid", 1, 1, "", sigmoid }, { "Tanh", 1, 1, "", tangent }, { "Softmax", 1, 1, " axis ", softmax },
    { "Identity", 1, 1, "", identity }, { "Cast", 1, 1, " to ", cast }, { "Shape", 1, 1, " start end ", shape_of },
    { "Range", 3, 3, "", range }, { "Reshape", 2, 2, "", reshape }, { "Flatten", 1, 1, " axis ", flatten },
    { "Squeeze", 1, 1, "", squeeze }, { "Transpose", 1, 1, " perm ", transpose },
    { "Concat", 1, ONNX_MAX_IN, " axis ", concat }, { "Slice", 3, 4, "", slice },
    { "Gather", 2, 2, " axis ", gather }, { "ReduceSum", 2, 2, " keepdims noop_with_empty_axes ", reduce_sum },
    { "MatMul", 2, 2, "", matmul }, { "Gemm", 2, 3, " alpha beta transA transB ", gemm },
    { "Conv", 2, 3, " kernel_shape strides pads dilations group ", conv },
    { "ConvTranspose", 2, 3, " kernel_shape strides pads dilations group ", conv_transpose },
    { "GridSample", 2, 2, " mode padding_mode align_corners ", grid_sample },
    { "MaxPool", 1, 1, " kernel_shape strides pads ceil_mode ", max_pool },
    { "GlobalAveragePool", 1, 1, "", global_average_pool },
    { "Resize", 1, 4, " mode coordinate_transformation_mode nearest_mode ", resize },
    { "RoiAlign", 3, 3, " mode coordinate_transformation_mode output_height output_width sampling_ratio spatial_scale ",
      roi_align },
    { "LayerNormalization", 3, 3, " axis epsilon ", layer_norm },
    { "BatchNormalization", 5, 5, " epsilon momentum training_mode ", batch_norm },
};

const onnx_rule *onnx_rule_find(const char *op)
{
    for (size_t i = 0; i < LT_COUNT(rules); i++)
        if (strcmp(rules[i].op, op) == 0)
            return &rules[i];
    return NULL;
}
