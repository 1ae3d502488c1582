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

/* Known whole numbers become a tensor beside a tensor of such. */
static lt_tensor *operand(onnx_call *c, int i)
{
    const onnx_value *other = 1 - i < c->n_in ? c->in[1 - i] : NULL;
    const lt_shape shape = onnx_shape(c, i);

    if (!onnx_is_known(c, i) || !other || !other->whole)
        return onnx_tensor(c, i);
    return onnx_charge(c, lt_shape_numel(&shape)) ? onnx_reals(c, i, shape) : NULL;
}

static void binary(onnx_call *c, lt_tensor *(*op)(lt_tensor *a, lt_tensor *b))
{
    lt_tensor *a = operand(c, 0), *b = operand(c, 1);

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
static void larger(onnx_call *c) { binary(c, onnx_max); }

/* Whole numbers are divided towards zero. A float's quotient of two that it holds exactly is cut off right. */
static void divide(onnx_call *c)
{
    binary(c, onnx_div);
    if (c->out.t && onnx_all_whole(c))
        c->out.t = onnx_trunc(c->out.t);
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
    { "Add", 2, 2, "", add, true },
    { "Sub", 2, 2, "", subtract, true },
    { "Mul", 2, 2, "", multiply, true },
    { "Div", 2, 2, "", divide, true },
    { "Max", 2, 2, "", larger, true },
    { "Sqrt", 1, 1, "", square_root, false },
    { "Erf", 1, 1, "", error_function, false },
    { "Relu", 1, 1, "", relu, true },
    { "LeakyRelu", 1, 1, " alpha ", leaky_relu, false },
    { "Elu", 1, 1, " alpha ", elu, false },
    { "Sigmoid", 1, 1, "", sigmoid, false },
    { "Tanh", 1, 1, "", tangent, false },
    { 0 },
};

const onnx_rule *onnx_rule_find(const char *op)
{
    const onnx_rule *const tables[] = { element_rules, onnx_shape_rules, onnx_layer_rules };

    for (size_t i = 0; i < LT_COUNT(tables); i++)
        for (const onnx_rule *r = tables[i]; r->op; r++)
            if (strcmp(r->op, op) == 0)
                return r;
    return NULL;
}
