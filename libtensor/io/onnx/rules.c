/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What each ONNX operator is in our ops. A rule takes what docs/onnx.md lists and refuses the rest, so that
 * a model is recorded as it is meant or not at all. Those that work element by element are here.
 *
 * Source: onnx/onnx, docs/Operators.md.
 */
#include "libtensor/io/onnx/import.h"
#include "libtensor/ops/ops.h"

#include <string.h>

static void unary(onnx_call *c, lt_tensor *(*op)(lt_tensor *x))
{
    lt_tensor *x = onnx_tensor(c, 0);

    c->out.t = x ? op(x) : NULL;
}

typedef int64_t whole_fn(onnx_call *c, const int64_t *x);

/* All operands, one after another. Known whole numbers stay known, and become a tensor beside a tensor of such. */
static void join(onnx_call *c, lt_tensor *(*op)(lt_tensor *a, lt_tensor *b), whole_fn *fold)
{
    lt_tensor *(*const as_tensor)(onnx_call *, int) = onnx_all_whole(c) ? onnx_either : onnx_tensor;
    lt_tensor *all;

    if (onnx_all_known(c)) {
        onnx_fold(c, fold);
        return;
    }
    all = as_tensor(c, 0);
    if (all && c->n_in == 1)
        all = lt_reshape(all, all->shape);
    for (int i = 1; i < c->n_in; i++) {
        lt_tensor *next = as_tensor(c, i);

        all = all && next ? op(all, next) : NULL;
    }
    c->out.t = all;
}

/* Whole numbers wrap, as they do where a model runs. */
static int64_t whole_sum(onnx_call *c, const int64_t *x)
{
    uint64_t sum = 0;

    for (int i = 0; i < c->n_in; i++)
        sum += (uint64_t)x[i];
    return (int64_t)sum;
}

static int64_t whole_max(onnx_call *c, const int64_t *x)
{
    int64_t max = x[0];

    for (int i = 1; i < c->n_in; i++)
        max = lt_max_i64(max, x[i]);
    return max;
}

static int64_t whole_min(onnx_call *c, const int64_t *x)
{
    int64_t min = x[0];

    for (int i = 1; i < c->n_in; i++)
        min = lt_min_i64(min, x[i]);
    return min;
}

static int64_t whole_difference(onnx_call *c, const int64_t *x)
{
    (void)c;
    return (int64_t)((uint64_t)x[0] - (uint64_t)x[1]);
}

static int64_t whole_product(onnx_call *c, const int64_t *x)
{
    (void)c;
    return (int64_t)((uint64_t)x[0] * (uint64_t)x[1]);
}

static int64_t whole_quotient(onnx_call *c, const int64_t *x)
{
    if (x[1] == 0)
        onnx_fail(c, "a division by 0");
    return x[1] == 0 ? 0 : x[1] == -1 ? (int64_t)(0 - (uint64_t)x[0]) : x[0] / x[1];
}

static void relu(onnx_call *c) { unary(c, lt_relu); }
static void sigmoid(onnx_call *c) { unary(c, lt_sigmoid); }
static void tangent(onnx_call *c) { unary(c, lt_tanh); }
static void gelu(onnx_call *c) { unary(c, lt_gelu); }
static void error_function(onnx_call *c) { unary(c, onnx_erf); }
static void square_root(onnx_call *c) { unary(c, onnx_sqrt); }
static void add(onnx_call *c) { join(c, lt_add, whole_sum); }
static void subtract(onnx_call *c) { join(c, lt_sub, whole_difference); }
static void multiply(onnx_call *c) { join(c, lt_mul, whole_product); }
static void larger(onnx_call *c) { join(c, onnx_max, whole_max); }
static void smaller(onnx_call *c) { join(c, onnx_min, whole_min); }

/* Whole numbers are divided towards zero. A float's quotient of two that it holds exactly is cut off right. */
static void divide(onnx_call *c)
{
    join(c, onnx_div, whole_quotient);
    if (c->out.t && onnx_all_whole(c))
        c->out.t = onnx_trunc(c->out.t);
}

/* x to a whole power, which stands for a number of any type, is whole where x is. */
static void power(onnx_call *c)
{
    const bool whole = c->in[0]->whole || onnx_is_known(c, 0);
    lt_tensor *x = onnx_either(c, 0), *y = onnx_either(c, 1);

    c->out.t = x && y ? onnx_pow(x, y) : NULL;
    if (c->out.t && whole)
        c->out.t = onnx_trunc(c->out.t);
    c->out.whole = whole;
}

/* Each bound may be left out. */
static void clip(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0), *lo = onnx_tensor(c, 1), *hi = onnx_tensor(c, 2);

    if (c->status)
        return;
    if ((lo && lt_numel(lo) != 1) || (hi && lt_numel(hi) != 1))
        onnx_fail(c, "a bound is not one number");
    x = lo ? onnx_max(x, lt_reshape(lo, (lt_shape){ 0 })) : x;
    x = hi ? onnx_min(x, lt_reshape(hi, (lt_shape){ 0 })) : x;
    c->out.t = lo || hi ? x : lt_reshape(x, x->shape);
}

static void hard_sigmoid(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);

    c->out.t = x ? onnx_hard_sigmoid(x, onnx_attr_float(c, "alpha", .2), onnx_attr_float(c, "beta", .5)) : NULL;
}

static void hard_swish(onnx_call *c)
{
    lt_tensor *x = onnx_tensor(c, 0);

    c->out.t = x ? lt_mul(x, onnx_hard_sigmoid(x, 1. / 6, .5)) : NULL;
}

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

static const onnx_rule element_rules[] = {
    { "Add", 2, 2, "", add, ONNX_WHOLE },
    { "Sum", 1, ONNX_MAX_IN, "", add, ONNX_WHOLE },
    { "Sub", 2, 2, "", subtract, ONNX_WHOLE },
    { "Mul", 2, 2, "", multiply, ONNX_WHOLE },
    { "Div", 2, 2, "", divide, ONNX_WHOLE },
    { "Max", 1, ONNX_MAX_IN, "", larger, ONNX_WHOLE },
    { "Min", 1, ONNX_MAX_IN, "", smaller, ONNX_WHOLE },
    { "Pow", 2, 2, "", power, 0 },
    { "Clip", 1, 3, "", clip, 0 },
    { "Sqrt", 1, 1, "", square_root, 0 },
    { "Erf", 1, 1, "", error_function, 0 },
    { "Relu", 1, 1, "", relu, ONNX_WHOLE },
    { "LeakyRelu", 1, 1, " alpha ", leaky_relu, 0 },
    { "Elu", 1, 1, " alpha ", elu, 0 },
    { "Gelu", 1, 1, " approximate=none ", gelu, 0 },
    { "HardSigmoid", 1, 1, " alpha beta ", hard_sigmoid, 0 },
    { "HardSwish", 1, 1, "", hard_swish, 0 },
    { "Sigmoid", 1, 1, "", sigmoid, 0 },
    { "Tanh", 1, 1, "", tangent, 0 },
    { 0 },
};

const onnx_rule *onnx_rule_find(const char *op)
{
    const onnx_rule *const tables[] = {
        element_rules, onnx_number_rules, onnx_shape_rules, onnx_reduce_rules, onnx_layer_rules,
    };

    for (size_t i = 0; i < LT_COUNT(tables); i++)
        for (const onnx_rule *r = tables[i]; r->op; r++)
            if (strcmp(r->op, op) == 0)
                return r;
    return NULL;
}
