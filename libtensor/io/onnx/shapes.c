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

/* What the file says stays what it says: another node may want it as such. */
static void identity(onnx_call *c)
{
    if (c->in[0]->constant)
        c->out = (onnx_value){ .t = c->in[0]->t, .constant = c->in[0]->constant };
    else
        view(c, onnx_shape(c, 0));
}

/* What it is at inference. Its mask is for training. */
static void dropout(onnx_call *c)
{
    int n;

    if (onnx_has(c, 2) && (!onnx_is_known(c, 2) || *onnx_ints(c, 2, &n)))
        onnx_fail(c, "is told to train");
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
    const bool zero_is_zero = onnx_attr_int(c, "allowzero", 0, 0, 1);

    if (to.rank > LT_MAX_RANK) {
        onnx_fail(c, "%d dimensions, at most %d are possible", to.rank, LT_MAX_RANK);
        return;
    }
    for (int i = 0; i < to.rank; i++)
        to.dim[i] = dim[i] == 0 && !zero_is_zero && i < from.rank ? from.dim[i] : dim[i];
    close_shape(c, &to, lt_shape_numel(&from));
    view(c, to);
}

static void flatten(onnx_call *c)
{
    const lt_shape from = onnx_shape(c, 0);
    const int axis = onnx_attr_int(c, "axis", 1, -from.rank, lt_max_i64(1, from.rank));
    lt_shape to = { .rank = 2, .dim = { 1, 1 } };

    for (int i = 0; i < from.rank; i++)
        to.dim[i >= (axis < 0 ? axis + from.rank : axis)] *= from.dim[i];
    view(c, to);
}

static void squeeze(onnx_call *c)
{
    const lt_shape from = onnx_shape(c, 0);
    const unsigned axes = onnx_axes(c, 1, from.rank);
    lt_shape to = { 0 };

    for (int i = 0; i < from.rank; i++) {
        const bool goes = axes ? axes & 1u << i : from.dim[i] == 1;

        if (goes && from.dim[i] != 1)
            onnx_fail(c, "dimension %d is %jd, want 1", i, (intmax_t)from.dim[i]);
        if (!goes)
            to.dim[to.rank++] = from.dim[i];
    }
    view(c, to);
}

static void unsqueeze(onnx_call *c)
{
    const lt_shape from = onnx_shape(c, 0);
    lt_shape to = { 0 };
    unsigned axes;
    int n, left = 0;

    if (!onnx_attr_ints(c, "axes", &n))
        onnx_ints(c, 1, &n);
    if (n < 1 || from.rank + n > LT_MAX_RANK)
        onnx_fail(c, "%d and %d dimensions, at most %d are possible", from.rank, n, LT_MAX_RANK);
    axes = c->status ? 0 : onnx_axes(c, 1, from.rank + n);
    for (int i = 0; axes && i < from.rank + n; i++)
        to.dim[to.rank++] = axes & 1u << i ? 1 : from.dim[left++];
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

/* ---- pieces ------------------------------------------------------------------------------------------------------ */

/* Elements of an axis: `count` of them from `start` by `step` */
typedef struct {
    int axis;
    int64_t start, step, count;
} stretch;

/* Places below 0 count from the end, those outside are moved to the border. */
static stretch stretch_of(onnx_call *c, const lt_shape *shape, int64_t axis, int64_t start, int64_t end, int64_t step)
{
    const int64_t rank = shape->rank, at = axis < 0 ? axis + rank : axis;
    stretch s = { .step = step };
    int64_t n;

    if (at < 0 || at >= rank) {
        onnx_fail(c, "axis %jd of %jd dimensions", (intmax_t)axis, (intmax_t)rank);
        return s;
    }
    if (step == 0 || step < -INT32_MAX || step > INT32_MAX) {
        onnx_fail(c, "a step of %jd", (intmax_t)step);
        return s;
    }
    n = shape->dim[at];
    start += start < 0 ? n : 0;
    end += end < 0 ? n : 0;
    s.axis = (int)at;
    s.start = step > 0 ? lt_max_i64(0, lt_min_i64(n, start)) : lt_max_i64(0, lt_min_i64(n - 1, start));
    end = step > 0 ? lt_max_i64(0, lt_min_i64(n, end)) : lt_max_i64(-1, lt_min_i64(n - 1, end));
    s.count = step > 0 ? lt_ceil_div(lt_max_i64(0, end - s.start), step)
                       : lt_ceil_div(lt_max_i64(0, s.start - end), -step);
    if (n == 0)
        s.count = 0;
    return s;
}

/* One piece, or with a step its elements by their numbers */
static lt_tensor *take_stretch(onnx_call *c, lt_tensor *x, const stretch *s)
{
    int32_t *places;
    lt_tensor *out = x;

    if (s->step == 1)
        return lt_slice(x, s->axis, s->start, s->count);
    if (!onnx_charge(c, s->count))
        return x;
    places = lt_alloc((size_t)s->count * sizeof(*places));
    if (!places)
        onnx_no_memory(c);
    for (int64_t i = 0; places && i < s->count; i++)
        places[i] = (int32_t)(s->start + i * s->step);
    if (places)
        out = onnx_gather(x, lt_constant(c->g, LT_I32, LT_SHAPE(s->count), places), s->axis);
    lt_release(places);
    return out;
}

static void slice_known(onnx_call *c, const stretch *s)
{
    const lt_shape from = onnx_shape(c, 0);
    int64_t *list;

    if (from.rank != 1)
        onnx_fail(c, "known numbers of %d dimensions, want 1", from.rank);
    list = c->status ? NULL : onnx_list(c, s->count);
    for (int64_t i = 0; list && i < s->count; i++)
        list[i] = c->in[0]->ints[s->start + i * s->step];
    c->out.ints = list;
    c->out.shape = LT_SHAPE(s->count);
}

static void slice(onnx_call *c)
{
    const bool known = onnx_is_known(c, 0);
    lt_tensor *x = known ? NULL : onnx_tensor(c, 0);
    int n, n_end, n_axis = 0, n_step = 0;
    const int64_t *start = onnx_ints(c, 1, &n), *end = onnx_ints(c, 2, &n_end);
    const int64_t *axis = onnx_has(c, 3) ? onnx_ints(c, 3, &n_axis) : NULL;
    const int64_t *step = onnx_has(c, 4) ? onnx_ints(c, 4, &n_step) : NULL;

    if (n != n_end || (axis && n != n_axis) || (step && n != n_step) || n > LT_MAX_RANK || n == 0 || (known && n > 1))
        onnx_fail(c, "%d starts and %d ends", n, n_end);
    for (int i = 0; i < n && c->status == LT_OK; i++) {
        const lt_shape shape = x ? x->shape : onnx_shape(c, 0);
        const stretch s = stretch_of(c, &shape, axis ? axis[i] : i, start[i], end[i], step ? step[i] : 1);

        if (c->status == LT_OK && known)
            slice_known(c, &s);
        else if (c->status == LT_OK)
            x = take_stretch(c, x, &s);
    }
    c->out.t = x;
}

/* How long piece i is: said by an attribute of older sets or by an input, or all are equal but for what remains */
static int64_t piece_length(onnx_call *c, int i, int64_t size)
{
    const int pieces = c->node->n_out;
    int n;
    const int64_t *said = onnx_attr_ints(c, "split", &n);
    const int64_t each = lt_ceil_div(size, pieces);

    if (!said && onnx_has(c, 1))
        said = onnx_ints(c, 1, &n);
    if (said && n != pieces)
        onnx_fail(c, "%d lengths for %d results", n, pieces);
    if (c->status)
        return 0;
    return said ? said[i] : lt_max_i64(0, lt_min_i64(each, size - i * each));
}

static void split(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    const int axis = onnx_axis(c, 0), pieces = c->node->n_out;
    int64_t at = 0;

    onnx_attr_int(c, "num_outputs", pieces, pieces, pieces);
    for (int i = 0; i < pieces && c->status == LT_OK; i++) {
        const int64_t size = lt_dim(x, axis), n = piece_length(c, i, size);
        lt_tensor **piece = i ? &c->more[i - 1] : &c->out.t;

        if (n < 0 || n > size - at || (i == pieces - 1 && at + n != size))
            onnx_fail(c, "its pieces are not the %jd elements of axis %d", (intmax_t)size, axis);
        if (c->status == LT_OK)
            *piece = lt_slice(x, axis, at, n);
        at += n;
    }
}

/* The place of each index, which counts from the end below 0 */
static bool find_places(onnx_call *c, int64_t size, int32_t *places)
{
    int n;
    const int64_t *index = onnx_ints(c, 1, &n);

    for (int i = 0; i < n && c->status == LT_OK; i++) {
        const int64_t at = index[i] < 0 ? index[i] + size : index[i];

        if (at < 0 || at >= size || at > INT32_MAX)
            onnx_fail(c, "index %jd of %jd elements", (intmax_t)index[i], (intmax_t)size);
        places[i] = (int32_t)at;
    }
    return c->status == LT_OK;
}

static void gather_known(onnx_call *c, const int32_t *places)
{
    const lt_shape shape = onnx_shape(c, 1);
    const int64_t n = lt_shape_numel(&shape);
    int64_t *list = onnx_list(c, n);

    if (onnx_shape(c, 0).rank != 1)
        onnx_fail(c, "known numbers of %d dimensions, want 1", onnx_shape(c, 0).rank);
    for (int64_t i = 0; list && i < n && c->status == LT_OK; i++)
        list[i] = c->in[0]->ints[places[i]];
    c->out.ints = list;
    c->out.shape = shape;
}

/* The index's dimensions take the place of the axis: none, when it is one number. */
static void gather_tensor(onnx_call *c, lt_tensor *x, const int32_t *places, int axis)
{
    const lt_shape index = onnx_shape(c, 1);
    const int64_t n = lt_shape_numel(&index);
    lt_shape to = { 0 };

    if (x->shape.rank - 1 + index.rank > LT_MAX_RANK)
        onnx_fail(c, "%d dimensions, at most %d are possible", x->shape.rank - 1 + index.rank, LT_MAX_RANK);
    if (c->status || !onnx_charge(c, n))
        return;
    for (int i = 0; i < axis; i++)
        to.dim[to.rank++] = lt_dim(x, i);
    for (int i = 0; i < index.rank; i++)
        to.dim[to.rank++] = index.dim[i];
    for (int i = axis + 1; i < x->shape.rank; i++)
        to.dim[to.rank++] = lt_dim(x, i);
    x = n == 1 ? lt_slice(x, axis, places[0], 1)
               : onnx_gather(x, lt_constant(c->g, LT_I32, LT_SHAPE(n), places), axis);
    c->out.t = lt_reshape(x, to);
}

static void gather(onnx_call *c)
{
    const bool known = onnx_is_known(c, 0);
    lt_tensor *x = known ? NULL : onnx_tensor(c, 0);
    const lt_shape from = onnx_shape(c, 0);
    const int axis = onnx_axis(c, 0);
    int n;
    int32_t *places;

    onnx_ints(c, 1, &n);
    if (c->status)
        return;
    places = lt_alloc((size_t)n * sizeof(*places));
    if (!places)
        onnx_no_memory(c);
    else if (find_places(c, from.dim[axis], places) && known)
        gather_known(c, places);
    else if (c->status == LT_OK)
        gather_tensor(c, x, places, axis);
    lt_release(places);
}

/* ---- borders ----------------------------------------------------------------------------------------------------- */

/* What is said of n axes, before and behind each, as it is of all */
static void place_pads(onnx_call *c, const lt_tensor *x, int64_t *before, int64_t *behind)
{
    const int rank = x->shape.rank;
    int n, n_axis = rank;
    const int64_t *pads = onnx_ints(c, 1, &n), *axis = onnx_has(c, 3) ? onnx_ints(c, 3, &n_axis) : NULL;

    if (n != 2 * n_axis || n_axis > rank)
        onnx_fail(c, "%d borders of %d dimensions", n, n_axis);
    for (int i = 0; i < n_axis && c->status == LT_OK; i++) {
        const int64_t at = !axis ? i : axis[i] < 0 ? axis[i] + rank : axis[i];

        if (at < 0 || at >= rank || pads[i] < -ONNX_MAX_SIZE || pads[i] > ONNX_MAX_SIZE
            || pads[i + n_axis] < -ONNX_MAX_SIZE || pads[i + n_axis] > ONNX_MAX_SIZE) {
            onnx_fail(c, "borders that cannot be");
            return;
        }
        before[at] = pads[i];
        behind[at] = pads[i + n_axis];
    }
}

static onnx_pad_mode pad_mode(onnx_call *c)
{
    if (onnx_attr_is(c, "mode", "constant", "edge"))
        return ONNX_PAD_EDGE;
    if (onnx_attr_is(c, "mode", "constant", "reflect"))
        return ONNX_PAD_REFLECT;
    if (!onnx_attr_is(c, "mode", "constant", "constant"))
        onnx_fail(c, "attribute \"mode\" is \"%s\"; constant, edge and reflect are read", onnx_attr(c, "mode")->text);
    return ONNX_PAD_VALUE;
}

static void pad(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);
    int64_t before[LT_MAX_RANK] = { 0 }, behind[LT_MAX_RANK] = { 0 };
    const onnx_pad_mode mode = pad_mode(c);
    const lt_onnx_tensor *k = onnx_has(c, 2) ? c->in[2]->constant : NULL;
    float value = 0;

    if (c->status)
        return;
    place_pads(c, x, before, behind);
    if (onnx_has(c, 2) && (!k || lt_shape_numel(&k->shape) != 1))
        onnx_fail(c, "its value is not one number that is known before the model runs");
    else if (k)
        memcpy(&value, k->data, sizeof(value));
    if (c->status == LT_OK)
        c->out.t = x->shape.rank ? onnx_pad(x, before, behind, mode, (double)value) : lt_reshape(x, x->shape);
}

const onnx_rule onnx_shape_rules[] = {
    { "Identity", 1, 1, "", identity, ONNX_WHOLE },
    { "Dropout", 1, 3, " ratio seed ", dropout, ONNX_WHOLE | ONNX_MANY },
    { "Reshape", 2, 2, " allowzero ", reshape, ONNX_WHOLE },
    { "Flatten", 1, 1, " axis ", flatten, ONNX_WHOLE },
    { "Squeeze", 1, 2, " axes ", squeeze, ONNX_WHOLE },
    { "Unsqueeze", 1, 2, " axes ", unsqueeze, ONNX_WHOLE },
    { "Transpose", 1, 1, " perm ", transpose, ONNX_WHOLE },
    { "Concat", 1, ONNX_MAX_IN, " axis ", concat, ONNX_WHOLE },
    { "Slice", 3, 5, "", slice, ONNX_WHOLE },
    { "Split", 1, 2, " axis split num_outputs ", split, ONNX_WHOLE | ONNX_MANY },
    { "Gather", 2, 2, " axis ", gather, ONNX_WHOLE },
    { "Pad", 2, 4, " mode ", pad, 0 },
    { 0 },
};
