/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Ops that are only met in an imported model: what our larger ops were taken apart into. No gradient.
 */
#include "libtensor/io/onnx/import.h"
#include "libtensor/ops/broadcast.h"

#include <math.h>

/* ---- element by element ------------------------------------------------------------------------------------- */

static void by_element(const lt_call *c, int64_t at, size_t n, double (*fn)(double))
{
    const lt_real *x = (const lt_real *)c->in[0]->data + at;
    lt_real *y = (lt_real *)c->out->data + at;

    for (size_t i = 0; i < n; i++)
        y[i] = (lt_real)fn((double)x[i]);
}

/* Towards zero; a whole number has no -0. */
static double whole(double x) { return trunc(x) + 0.; }

static void erf_chunk(const lt_call *c, int64_t at, size_t n) { by_element(c, at, n, erf); }
static void sqrt_chunk(const lt_call *c, int64_t at, size_t n) { by_element(c, at, n, sqrt); }
static void trunc_chunk(const lt_call *c, int64_t at, size_t n) { by_element(c, at, n, whole); }

static void erf_forward(const lt_call *c) { op_by_chunk(c, lt_numel(c->out), erf_chunk); }
static void sqrt_forward(const lt_call *c) { op_by_chunk(c, lt_numel(c->out), sqrt_chunk); }
static void trunc_forward(const lt_call *c) { op_by_chunk(c, lt_numel(c->out), trunc_chunk); }

static const lt_op erf_op = { .name = "erf", .infer = op_same_shape, .forward = erf_forward };
static const lt_op sqrt_op = { .name = "sqrt", .infer = op_same_shape, .forward = sqrt_forward };
static const lt_op trunc_op = { .name = "trunc", .infer = op_same_shape, .forward = trunc_forward };

lt_tensor *onnx_erf(lt_tensor *x) { return lt_apply(&erf_op, NULL, 0, &x, 1); }
lt_tensor *onnx_sqrt(lt_tensor *x) { return lt_apply(&sqrt_op, NULL, 0, &x, 1); }
lt_tensor *onnx_trunc(lt_tensor *x) { return lt_apply(&trunc_op, NULL, 0, &x, 1); }

/* ---- two operands --------------------------------------------------------------------------------------------- */

static void div_row(const lt_call *c, int64_t row)
{
    const broadcast b = broadcast_plan(c->out, c->in[0], c->in[1]);
    const lt_real *x = (const lt_real *)c->in[0]->data + broadcast_row(&b, 0, row);
    const lt_real *y = (const lt_real *)c->in[1]->data + broadcast_row(&b, 1, row);
    lt_real *out = (lt_real *)c->out->data + row * b.inner;

    for (int64_t i = 0; i < b.inner; i++)
        out[i] = x[i * b.step[0]] / y[i * b.step[1]];
}

static void max_row(const lt_call *c, int64_t row)
{
    const broadcast b = broadcast_plan(c->out, c->in[0], c->in[1]);
    const lt_real *x = (const lt_real *)c->in[0]->data + broadcast_row(&b, 0, row);
    const lt_real *y = (const lt_real *)c->in[1]->data + broadcast_row(&b, 1, row);
    lt_real *out = (lt_real *)c->out->data + row * b.inner;

    for (int64_t i = 0; i < b.inner; i++) {
        const lt_real p = x[i * b.step[0]], q = y[i * b.step[1]];

        out[i] = p > q || isnan(p) ? p : q;
    }
}

static void by_broadcast_row(const lt_call *c, op_row_fn fn)
{
    const broadcast b = broadcast_plan(c->out, c->in[0], c->in[1]);

    if (lt_numel(c->out))
        op_by_row(c, b.n_rows, b.inner, fn);
}

static void div_forward(const lt_call *c) { by_broadcast_row(c, div_row); }
static void max_forward(const lt_call *c) { by_broadcast_row(c, max_row); }

static const lt_op div_op = { .name = "div", .infer = broadcast_infer, .forward = div_forward };
static const lt_op max_op = { .name = "max", .infer = broadcast_infer, .forward = max_forward };

lt_tensor *onnx_div(lt_tensor *a, lt_tensor *b) { return lt_apply(&div_op, NULL, 0, (lt_tensor *[]){ a, b }, 2); }
lt_tensor *onnx_max(lt_tensor *a, lt_tensor *b) { return lt_apply(&max_op, NULL, 0, (lt_tensor *[]){ a, b }, 2); }

/* ---- along an axis, which the rules have looked at ------------------------------------------------------------ */

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
