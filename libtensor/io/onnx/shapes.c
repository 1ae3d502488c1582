/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rules of the operators that move values, or count them: shapes, pieces, orders, known numbers.
 */
#include "libtensor/base/arena.h"
#include "libtensor/io/onnx/import.h"
#include "libtensor/ops/ops.h"

#include <string.h>

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

    if (c->status)
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

static void concat_known(onnx_call *c)
{
    int64_t *all, n = 0;
    int m;

    for (int i = 0; i < c->n_in; i++) {
        onnx_ints(c, i, &m);
        n += onnx_shape(c, i).rank == 1 ? m : 0;
    }
    all = onnx_list(c, n);
    if (!all)
        return;
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
    const int axis = onnx_axis(c, 0);

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
    for (int i = 0; i < n && c->status == LT_OK; i++)
        x = slice_axis(c, x, axis ? axis[i] : i, start[i], end[i]);
    c->out.t = x;
}

static void gather(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const int axis = onnx_axis(c, 0);
    int n;
    const int64_t *index = onnx_ints(c, 1, &n);
    int32_t *places = lt_alloc((size_t)n * sizeof(*places));

    if (!places)
        onnx_no_memory(c);
    for (int i = 0; c->status == LT_OK && i < n; i++) {
        const int64_t size = lt_dim(x, axis), at = index[i] < 0 ? index[i] + size : index[i];

        if (at < 0 || at >= size || at > INT32_MAX)
            onnx_fail(c, "index %jd of %jd elements", (intmax_t)index[i], (intmax_t)size);
        places[i] = (int32_t)at;
    }
    if (onnx_shape(c, 1).rank != 1)
        onnx_fail(c, "the indices are no list");
    if (c->status == LT_OK && onnx_charge(c, n))
        c->out.t = onnx_gather(x, lt_constant(c->g, LT_I32, LT_SHAPE(n), places), axis);
    lt_release(places);
}

static void shape_of(onnx_call *c)
{
    const lt_shape s = onnx_shape(c, 0);
    int start = onnx_attr_int(c, "start", 0, -s.rank, s.rank), end = onnx_attr_int(c, "end", s.rank, -s.rank, s.rank);
    int64_t *dim = onnx_list(c, LT_MAX_RANK);

    if (!dim)
        return;
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
    if (from_to_by[0] != 0 || from_to_by[2] != 1 || n < 0 || n > ONNX_MAX_SIZE) {
        onnx_fail(c, "from %jd to %jd by %jd; from 0 to %d at most by 1 is read", (intmax_t)from_to_by[0], (intmax_t)n,
                  (intmax_t)from_to_by[2], ONNX_MAX_SIZE);
        return;
    }
    list = onnx_list(c, n);
    if (!list)
        return;
    for (int64_t i = 0; i < n; i++)
        list[i] = i;
    c->out.ints = list;
    c->out.shape = LT_SHAPE(n);
}

/* Known numbers become constants; reals made whole are cut off, and remembered as such. */
static void cast(onnx_call *c)
{
    const int to = onnx_attr_int(c, "to", 0, 1, INT32_MAX);
    const lt_shape s = onnx_shape(c, 0);

    if (to != LT_ONNX_FLOAT && to != LT_ONNX_INT64 && to != LT_ONNX_INT32)
        onnx_fail(c, "to type %d; 1 (FLOAT), 6 (INT32), 7 (INT64) are read", to);
    if (onnx_is_known(c, 0) && to == LT_ONNX_FLOAT) {
        c->out.t = onnx_charge(c, lt_shape_numel(&s)) ? onnx_reals(c, 0, s) : NULL;
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
    const int keep = onnx_attr_int(c, "keepdims", 1, 0, 1), rank = onnx_shape(c, 0).rank;
    int n, axis;
    const int64_t *given = onnx_ints(c, 1, &n);
    lt_shape shape = { 0 };

    onnx_attr_int(c, "noop_with_empty_axes", 0, 0, 0);
    if (n != 1 || given[0] < -rank || given[0] >= rank)
        onnx_fail(c, "want one axis of the input's");
    if (c->status)
        return;
    axis = (int)(given[0] < 0 ? given[0] + rank : given[0]);
    x = onnx_sum(x, axis);
    for (int i = 0; i < x->shape.rank; i++)
        if (keep || i != axis)
            shape.dim[shape.rank++] = lt_dim(x, i);
    c->out.t = lt_reshape(x, shape);
}

const onnx_rule onnx_shape_rules[] = {
    { "Identity", 1, 1, "", identity, true },
    { "Cast", 1, 1, " to ", cast, false },
    { "Shape", 1, 1, " start end ", shape_of, false },
    { "Range", 3, 3, "", range, false },
    { "Reshape", 2, 2, "", reshape, true },
    { "Flatten", 1, 1, " axis ", flatten, true },
    { "Squeeze", 1, 1, "", squeeze, true },
    { "Transpose", 1, 1, " perm ", transpose, true },
    { "Concat", 1, ONNX_MAX_IN, " axis ", concat, true },
    { "Slice", 3, 4, "", slice, true },
    { "Gather", 2, 2, " axis ", gather, true },
    { "ReduceSum", 2, 2, " keepdims noop_with_empty_axes ", reduce_sum, true },
    { 0 },
};
