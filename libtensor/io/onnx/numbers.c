/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rules of the operators that make numbers from nothing, from a shape, or of another type: exporters count with them.
 * What can be known while recording is, so that it may become a shape.
 */
#include "libtensor/io/onnx/import.h"
#include "libtensor/ops/ops.h"

#include <math.h>
#include <string.h>

/* ---- constants --------------------------------------------------------------------------------------------------- */

/* The attribute's n numbers, of which there are already lists, as a tensor of the file */
static void numbers(onnx_call *c, lt_onnx_type type, lt_shape shape, const void *data)
{
    lt_onnx_tensor *t = lt_arena_alloc(c->arena, sizeof(*t));
    lt_status st;

    if (!t) {
        onnx_no_memory(c);
        return;
    }
    *t = (lt_onnx_tensor){ .name = c->node->out[0], .type = type, .shape = shape, .data = data };
    st = onnx_value_of(c->arena, t, &c->out);
    if (st)
        onnx_no_memory(c);
}

static void constant(onnx_call *c)
{
    const lt_onnx_attr *a = c->node->n_attr == 1 ? &c->node->attr[0] : NULL;

    if (!a)
        onnx_fail(c, "%d attributes, want one that holds its value", c->node->n_attr);
    else if (strcmp(a->name, "value") == 0 && a->kind == LT_ONNX_A_TENSOR)
        numbers(c, a->tensor->type, a->tensor->shape, a->tensor->data);
    else if (strcmp(a->name, "value_float") == 0 && a->kind == LT_ONNX_A_FLOAT)
        numbers(c, LT_ONNX_FLOAT, (lt_shape){ 0 }, &a->f);
    else if (strcmp(a->name, "value_int") == 0 && a->kind == LT_ONNX_A_INT)
        numbers(c, LT_ONNX_INT64, (lt_shape){ 0 }, &a->i);
    else if (strcmp(a->name, "value_floats") == 0 && a->kind == LT_ONNX_A_FLOATS)
        numbers(c, LT_ONNX_FLOAT, LT_SHAPE(a->n_floats), a->floats);
    else if (strcmp(a->name, "value_ints") == 0 && a->kind == LT_ONNX_A_INTS)
        numbers(c, LT_ONNX_INT64, LT_SHAPE(a->n_ints), a->ints);
    else
        onnx_fail(c, "attribute \"%s\" is of kind %d, which holds no value", a->name, (int)a->kind);
}

/* The shape that input i says, of which no dimension is open */
static lt_shape shape_said(onnx_call *c, int i)
{
    lt_shape s = { 0 };
    int n;
    const int64_t *dim = onnx_ints(c, i, &n);

    if (n > LT_MAX_RANK)
        onnx_fail(c, "%d dimensions, at most %d are possible", n, LT_MAX_RANK);
    for (int k = 0; k < n && c->status == LT_OK; k++) {
        if (dim[k] < 0 || dim[k] > INT32_MAX)
            onnx_fail(c, "a dimension of %jd", (intmax_t)dim[k]);
        s.dim[s.rank++] = dim[k];
    }
    return c->status ? (lt_shape){ 0 } : onnx_stretched(c, s, (lt_shape){ 0 });
}

static void constant_of_shape(onnx_call *c)
{
    static const float zero = 0;
    static const lt_onnx_tensor zeros = { .name = "", .type = LT_ONNX_FLOAT, .data = &zero };
    const lt_onnx_attr *a = onnx_attr(c, "value");
    const lt_onnx_tensor *t = a ? a->tensor : &zeros;
    const lt_shape shape = shape_said(c, 0);
    const int64_t n = lt_shape_numel(&shape);
    onnx_value one;

    if (!t || lt_shape_numel(&t->shape) != 1)
        onnx_fail(c, "attribute \"value\" is no tensor of one element");
    if (c->status || !onnx_charge(c, n))
        return;
    if (onnx_value_of(c->arena, t, &one)) {
        onnx_no_memory(c);
    } else if (one.constant) {
        lt_real *x = lt_constant_reals(c->g, shape, &c->out.t);
        float value;

        memcpy(&value, t->data, sizeof(value));
        for (int64_t i = 0; x && i < n; i++)
            x[i] = (lt_real)value;
    } else {
        int64_t *list = onnx_list(c, n);

        for (int64_t i = 0; list && i < n; i++)
            list[i] = one.ints[0];
        c->out.ints = list;
        c->out.shape = shape;
    }
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

/* ---- types and choices ------------------------------------------------------------------------------------------- */

/* Whole numbers are cut off; a truth is whether a number is not 0. */
static void cast_tensor(onnx_call *c, lt_tensor *x, lt_shape shape, int to)
{
    c->out.whole = to != LT_ONNX_FLOAT;
    if (to == LT_ONNX_FLOAT)
        c->out.t = lt_reshape(x, shape);
    else if (to == LT_ONNX_BOOL)
        c->out.t = onnx_equal(onnx_equal(x, lt_scalar(c->g, 0)), lt_scalar(c->g, 0));
    else
        c->out.t = onnx_trunc(x);
}

static int64_t the_same(onnx_call *c, const int64_t *x) { (void)c; return x[0]; }
static int64_t is_true(onnx_call *c, const int64_t *x) { (void)c; return x[0] != 0; }

/* Known numbers stay known, or become constants of reals. */
static void cast(onnx_call *c)
{
    const int to = onnx_attr_int(c, "to", 0, 1, INT32_MAX);
    const lt_shape s = onnx_shape(c, 0);

    if (to != LT_ONNX_FLOAT && to != LT_ONNX_INT64 && to != LT_ONNX_INT32 && to != LT_ONNX_BOOL)
        onnx_fail(c, "to type %d; 1 (FLOAT), 6 (INT32), 7 (INT64), 9 (BOOL) are read", to);
    else if (onnx_is_known(c, 0) && to == LT_ONNX_FLOAT)
        c->out.t = onnx_either(c, 0);
    else if (onnx_is_known(c, 0))
        onnx_fold(c, to == LT_ONNX_BOOL ? is_true : the_same);
    else if (onnx_tensor(c, 0))
        cast_tensor(c, onnx_tensor(c, 0), s, to);
}

static int64_t same_number(onnx_call *c, const int64_t *x) { (void)c; return x[0] == x[1]; }
static int64_t chosen(onnx_call *c, const int64_t *x) { (void)c; return x[0] ? x[1] : x[2]; }

static void equal(onnx_call *c)
{
    lt_tensor *a, *b;

    if (onnx_all_known(c)) {
        onnx_fold(c, same_number);
        return;
    }
    a = onnx_either(c, 0);
    b = onnx_either(c, 1);
    c->out.t = a && b ? onnx_equal(a, b) : NULL;
    c->out.whole = true;
}

static void where(onnx_call *c)
{
    lt_shape shape = onnx_stretched(c, onnx_shape(c, 0), onnx_shape(c, 1));
    lt_tensor *in[3];

    shape = onnx_stretched(c, shape, onnx_shape(c, 2));
    if (c->status)
        return;
    if (onnx_all_known(c)) {
        onnx_fold(c, chosen);
        return;
    }
    for (int i = 0; i < 3; i++) {
        lt_tensor *x = onnx_either(c, i);

        in[i] = x && !lt_same_shape(&x->shape, &shape) ? onnx_expand(x, shape) : x;
    }
    if (c->status == LT_OK)
        c->out.t = onnx_select(in[0], in[1], in[2]);
}

/* Of whole numbers that are known the result is too: a shape may come of it. */
static void expand(onnx_call *c)
{
    const lt_shape shape = onnx_stretched(c, onnx_shape(c, 0), shape_said(c, 1));
    int64_t *list, n = lt_shape_numel(&shape);
    lt_tensor *x;

    if (c->status)
        return;
    if (!onnx_is_known(c, 0)) {
        x = onnx_tensor(c, 0);
        c->out.t = x ? onnx_expand(x, shape) : NULL;
        return;
    }
    list = onnx_list(c, n);
    for (int64_t i = 0; list && i < n; i++)
        list[i] = c->in[0]->ints[onnx_met(&c->in[0]->shape, &shape, i)];
    c->out.ints = list;
    c->out.shape = shape;
}

const onnx_rule onnx_number_rules[] = {
    { "Constant", 0, 0, " value value_float value_int value_floats value_ints ", constant, 0 },
    { "ConstantOfShape", 1, 1, " value ", constant_of_shape, 0 },
    { "Shape", 1, 1, " start end ", shape_of, 0 },
    { "Range", 3, 3, "", range, 0 },
    { "Cast", 1, 1, " to saturate=1 ", cast, 0 },
    { "Equal", 2, 2, "", equal, 0 },
    { "Where", 3, 3, "", where, ONNX_WHOLE },
    { "Expand", 2, 2, "", expand, ONNX_WHOLE },
    { 0 },
};
