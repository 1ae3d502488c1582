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

static void binary(onnx_call *c, lt_tensor *(*op)(lt_tensor *a, lt_tensor *b))
{
    lt_tensor *a = onnx_tensor(c, 0), *b = onnx_tensor(c, 1);

    c->out.t = a && b ? op(a, b) : NULL;
    c->out.whole = a && b && c->in[0]->whole && c->in[1]->whole;
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

static void divide(onnx_call *c)
{
    binary(c, onnx_div);
    if (c->out.whole)
        onnx_fail(c, "of whole numbers; of reals is read");
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
    { "Add", 2, 2, "", add },
    { "Sub", 2, 2, "", subtract },
    { "Mul", 2, 2, "", multiply },
    { "Div", 2, 2, "", divide },
    { "Max", 2, 2, "", larger },
    { "Sqrt", 1, 1, "", square_root },
    { "Erf", 1, 1, "", error_function },
    { "Relu", 1, 1, "", relu },
    { "LeakyRelu", 1, 1, " alpha ", leaky_relu },
    { "Elu", 1, 1, " alpha ", elu },
    { "Sigmoid", 1, 1, "", sigmoid },
    { "Tanh", 1, 1, "", tangent },
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
