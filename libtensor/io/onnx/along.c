/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Ops that are only met in an imported model, along axes: sums, picks, stretches, borders. No gradient.
 */
#include "libtensor/io/onnx/import.h"
#include "libtensor/ops/broadcast.h"

/* ---- one axis, which the rules have looked at -------------------------------------------------------------------- */

typedef struct {
    int axis;
} axis_attr;

static int axis_of(const lt_call *c)
{
    return ((const axis_attr *)c->attr)->axis;
}

static lt_status sum_infer(lt_call *c)
{
    c->out->shape = c->in[0]->shape;
    c->out->shape.dim[axis_of(c)] = 1;
    return LT_OK;
}

static void sum_block(const lt_call *c, int64_t outer)
{
    const int64_t n = lt_dim(c->in[0], axis_of(c)), inner = op_inner(c->in[0], axis_of(c));
    const lt_real *x = (const lt_real *)c->in[0]->data + outer * n * inner;
    lt_real *y = (lt_real *)c->out->data + outer * inner;

    for (int64_t k = 0; k < inner; k++) {
        double sum = 0;

        for (int64_t i = 0; i < n; i++)
            sum += (double)x[i * inner + k];
        y[k] = (lt_real)sum;
    }
}

static void sum_forward(const lt_call *c)
{
    const int64_t outer = op_outer(c->in[0], axis_of(c));

    op_by_row(c, outer, lt_dim(c->in[0], axis_of(c)) * op_inner(c->in[0], axis_of(c)), sum_block);
}

static const lt_op sum_op = { .name = "reduce_sum", .infer = sum_infer, .forward = sum_forward };

lt_tensor *onnx_sum(lt_tensor *x, int axis)
{
    const axis_attr a = { axis };

    return lt_apply(&sum_op, &a, sizeof(a), &x, 1);
}

static lt_status gather_infer(lt_call *c)
{
    c->out->shape = c->in[0]->shape;
    c->out->shape.dim[axis_of(c)] = lt_dim(c->in[1], 0);
    return LT_OK;
}

static void gather_block(const lt_call *c, int64_t outer)
{
    const int64_t n = lt_dim(c->in[0], axis_of(c)), inner = op_inner(c->in[0], axis_of(c)), m = lt_dim(c->in[1], 0);
    const lt_real *x = (const lt_real *)c->in[0]->data + outer * n * inner;
    const int32_t *index = c->in[1]->data;
    lt_real *y = (lt_real *)c->out->data + outer * m * inner;

    for (int64_t i = 0; i < m; i++)
        memcpy(y + i * inner, x + index[i] * inner, (size_t)inner * sizeof(*y));
}

static void gather_forward(const lt_call *c)
{
    op_by_row(c, op_outer(c->in[0], axis_of(c)), lt_dim(c->in[1], 0) * op_inner(c->in[0], axis_of(c)), gather_block);
}

static const lt_op gather_op = {
    .name = "gather", .any_type = LT_ANY_TYPE_IN(1), .infer = gather_infer, .forward = gather_forward,
};

lt_tensor *onnx_gather(lt_tensor *x, lt_tensor *index, int axis)
{
    const axis_attr a = { axis };

    return lt_apply(&gather_op, &a, sizeof(a), (lt_tensor *[]){ x, index }, 2);
}

/* ---- stretches --------------------------------------------------------------------------------------------------- */

typedef struct {
    lt_shape shape;
} shape_attr;

static lt_status expand_infer(lt_call *c)
{
    c->out->shape = ((const shape_attr *)c->attr)->shape;
    return LT_OK;
}

static void expand_row(const lt_call *c, int64_t row)
{
    const broadcast b = broadcast_plan(c->out, c->in[0], c->in[0]);
    const lt_real *x = (const lt_real *)c->in[0]->data + broadcast_row(&b, 0, row);
    lt_real *y = (lt_real *)c->out->data + row * b.inner;

    for (int64_t i = 0; i < b.inner; i++)
        y[i] = x[i * b.step[0]];
}

static void expand_forward(const lt_call *c)
{
    const broadcast b = broadcast_plan(c->out, c->in[0], c->in[0]);

    if (lt_numel(c->out))
        op_by_row(c, b.n_rows, b.inner, expand_row);
}

static const lt_op expand_op = { .name = "expand", .infer = expand_infer, .forward = expand_forward };

lt_tensor *onnx_expand(lt_tensor *x, lt_shape shape)
{
    const shape_attr a = { shape };

    return lt_apply(&expand_op, &a, sizeof(a), &x, 1);
}

/* ---- borders ----------------------------------------------------------------------------------------------------- */

typedef struct {
    int64_t before[LT_MAX_RANK], behind[LT_MAX_RANK];
    onnx_pad_mode mode;
    double value;
} pad_attr;

static lt_status pad_infer(lt_call *c)
{
    const pad_attr *a = c->attr;
    const lt_shape *x = &c->in[0]->shape;

    c->out->shape = *x;
    for (int i = 0; i < x->rank; i++) {
        const int64_t n = x->dim[i], out = n + a->before[i] + a->behind[i];
        const int64_t most = lt_max_i64(a->before[i], a->behind[i]);

        if (out < 0 || (a->mode == ONNX_PAD_EDGE && n == 0 && out > 0))
            return lt_fail(c, "dimension %d of %jd elements has no border of %jd and %jd", i, (intmax_t)n,
                           (intmax_t)a->before[i], (intmax_t)a->behind[i]);
        if (a->mode == ONNX_PAD_REFLECT && most > 0 && most >= n)
            return lt_fail(c, "dimension %d of %jd elements has none to mirror for a border of %jd", i, (intmax_t)n,
                           (intmax_t)most);
        c->out->shape.dim[i] = out;
    }
    return LT_OK;
}

/* Which of n elements stands at place i, which may lie outside; -1: the value */
static int64_t inside(onnx_pad_mode mode, int64_t i, int64_t n)
{
    if (i >= 0 && i < n)
        return i;
    if (mode == ONNX_PAD_VALUE)
        return -1;
    if (mode == ONNX_PAD_EDGE)
        return i < 0 ? 0 : n - 1;
    return i < 0 ? -i : 2 * (n - 1) - i;
}

/* A row of the result: where the row it is made of starts in x, or -1 */
static int64_t source_row(const lt_call *c, int64_t row)
{
    const pad_attr *a = c->attr;
    const lt_shape *x = &c->in[0]->shape, *y = &c->out->shape;
    int64_t at = 0, step = x->dim[x->rank - 1];

    for (int i = x->rank - 2; i >= 0; i--) {
        const int64_t from = inside(a->mode, row % y->dim[i] - a->before[i], x->dim[i]);

        if (from < 0)
            return -1;
        at += from * step;
        step *= x->dim[i];
        row /= y->dim[i];
    }
    return at;
}

static void pad_row(const lt_call *c, int64_t row)
{
    const pad_attr *a = c->attr;
    const int last = (int)lt_max_i64(0, c->out->shape.rank - 1);
    const int64_t n = lt_dim(c->out, last), n_x = lt_dim(c->in[0], last), source = source_row(c, row);
    const lt_real *x = (const lt_real *)c->in[0]->data + lt_max_i64(0, source);
    lt_real *y = (lt_real *)c->out->data + row * n;

    for (int64_t i = 0; i < n; i++) {
        const int64_t from = source < 0 ? -1 : inside(a->mode, i - a->before[last], n_x);

        y[i] = from < 0 ? (lt_real)a->value : x[from];
    }
}

static void pad_forward(const lt_call *c)
{
    const int last = c->out->shape.rank - 1;

    if (lt_numel(c->out))
        op_by_row(c, op_outer(c->out, last), lt_dim(c->out, last), pad_row);
}

static const lt_op pad_op = { .name = "pad", .infer = pad_infer, .forward = pad_forward };

lt_tensor *onnx_pad(lt_tensor *x, const int64_t *before, const int64_t *behind, onnx_pad_mode mode, double value)
{
    pad_attr a = { .mode = mode, .value = value };

    memcpy(a.before, before, (size_t)x->shape.rank * sizeof(*before));
    memcpy(a.behind, behind, (size_t)x->shape.rank * sizeof(*behind));
    return lt_apply(&pad_op, &a, sizeof(a), &x, 1);
}
