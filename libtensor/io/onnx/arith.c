/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Ops that are only met in an imported model: what our larger ops were taken apart into, and others' have. No gradient.
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

typedef struct {
    double alpha, beta;
} line_attr;

/* NaN stays. */
static void hard_sigmoid_chunk(const lt_call *c, int64_t at, size_t n)
{
    const line_attr *a = c->attr;
    const lt_real *x = (const lt_real *)c->in[0]->data + at;
    lt_real *y = (lt_real *)c->out->data + at;

    for (size_t i = 0; i < n; i++) {
        const double line = a->alpha * (double)x[i] + a->beta;

        y[i] = (lt_real)(line < 0 ? 0 : line > 1 ? 1 : line);
    }
}

static void hard_sigmoid_forward(const lt_call *c) { op_by_chunk(c, lt_numel(c->out), hard_sigmoid_chunk); }

static const lt_op hard_sigmoid_op = {
    .name = "hard_sigmoid", .infer = op_same_shape, .forward = hard_sigmoid_forward,
};

lt_tensor *onnx_hard_sigmoid(lt_tensor *x, double alpha, double beta)
{
    const line_attr a = { alpha, beta };

    return lt_apply(&hard_sigmoid_op, &a, sizeof(a), &x, 1);
}

/* ---- two operands --------------------------------------------------------------------------------------------- */

typedef lt_real pair_fn(lt_real a, lt_real b);

static void by_pair(const lt_call *c, int64_t row, pair_fn *fn)
{
    const broadcast b = broadcast_plan(c->out, c->in[0], c->in[1]);
    const lt_real *x = (const lt_real *)c->in[0]->data + broadcast_row(&b, 0, row);
    const lt_real *y = (const lt_real *)c->in[1]->data + broadcast_row(&b, 1, row);
    lt_real *out = (lt_real *)c->out->data + row * b.inner;

    for (int64_t i = 0; i < b.inner; i++)
        out[i] = fn(x[i * b.step[0]], y[i * b.step[1]]);
}

static lt_real quotient(lt_real a, lt_real b) { return a / b; }
static lt_real larger(lt_real a, lt_real b) { return a > b || isnan(a) ? a : b; }
static lt_real smaller(lt_real a, lt_real b) { return a < b || isnan(a) ? a : b; }
static lt_real power(lt_real a, lt_real b) { return b == 2 ? a * a : (lt_real)pow((double)a, (double)b); }
static lt_real same(lt_real a, lt_real b) { return a == b; }

static void div_row(const lt_call *c, int64_t row) { by_pair(c, row, quotient); }
static void max_row(const lt_call *c, int64_t row) { by_pair(c, row, larger); }
static void min_row(const lt_call *c, int64_t row) { by_pair(c, row, smaller); }
static void pow_row(const lt_call *c, int64_t row) { by_pair(c, row, power); }
static void equal_row(const lt_call *c, int64_t row) { by_pair(c, row, same); }

static void by_broadcast_row(const lt_call *c, op_row_fn fn)
{
    const broadcast b = broadcast_plan(c->out, c->in[0], c->in[1]);

    if (lt_numel(c->out))
        op_by_row(c, b.n_rows, b.inner, fn);
}

static void div_forward(const lt_call *c) { by_broadcast_row(c, div_row); }
static void max_forward(const lt_call *c) { by_broadcast_row(c, max_row); }
static void min_forward(const lt_call *c) { by_broadcast_row(c, min_row); }
static void pow_forward(const lt_call *c) { by_broadcast_row(c, pow_row); }
static void equal_forward(const lt_call *c) { by_broadcast_row(c, equal_row); }

static const lt_op div_op = { .name = "div", .infer = broadcast_infer, .forward = div_forward };
static const lt_op max_op = { .name = "max", .infer = broadcast_infer, .forward = max_forward };
static const lt_op min_op = { .name = "min", .infer = broadcast_infer, .forward = min_forward };
static const lt_op pow_op = { .name = "pow", .infer = broadcast_infer, .forward = pow_forward };
static const lt_op equal_op = { .name = "equal", .infer = broadcast_infer, .forward = equal_forward };

static lt_tensor *apply_pair(const lt_op *op, lt_tensor *a, lt_tensor *b)
{
    return lt_apply(op, NULL, 0, (lt_tensor *[]){ a, b }, 2);
}

lt_tensor *onnx_div(lt_tensor *a, lt_tensor *b) { return apply_pair(&div_op, a, b); }
lt_tensor *onnx_max(lt_tensor *a, lt_tensor *b) { return apply_pair(&max_op, a, b); }
lt_tensor *onnx_min(lt_tensor *a, lt_tensor *b) { return apply_pair(&min_op, a, b); }
lt_tensor *onnx_pow(lt_tensor *a, lt_tensor *b) { return apply_pair(&pow_op, a, b); }
lt_tensor *onnx_equal(lt_tensor *a, lt_tensor *b) { return apply_pair(&equal_op, a, b); }

/* ---- a choice ---------------------------------------------------------------------------------------------------- */

static void select_chunk(const lt_call *c, int64_t at, size_t n)
{
    const lt_real *condition = (const lt_real *)c->in[0]->data + at, *x = (const lt_real *)c->in[1]->data + at;
    const lt_real *y = (const lt_real *)c->in[2]->data + at;
    lt_real *out = (lt_real *)c->out->data + at;

    for (size_t i = 0; i < n; i++)
        out[i] = condition[i] != 0 ? x[i] : y[i];
}

static void select_forward(const lt_call *c) { op_by_chunk(c, lt_numel(c->out), select_chunk); }

static const lt_op select_op = { .name = "where", .infer = op_same_shape, .forward = select_forward };

lt_tensor *onnx_select(lt_tensor *at, lt_tensor *x, lt_tensor *y)
{
    return lt_apply(&select_op, NULL, 0, (lt_tensor *[]){ at, x, y }, 3);
}
