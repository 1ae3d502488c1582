/* SPDX-License-Identifier: Apache-2.0 */
/* What each ONNX operator becomes: values as docs/Operators.md of onnx/onnx defines them, and what a rule refuses. A
 * model is a line of text: "y = Gather(x, [2, 0]) axis=1". */
#include "libtensor/graph/plan.h"
#include "libtensor/io/onnx/onnx.h"
#include "tests/io/hostile.h"

#include <ctype.h>

/* ---- a model of one line ----------------------------------------------------------------------------------------- */

enum { LIST = 8 };

typedef struct {
    lt_arena *arena;
    const char *at;
    lt_onnx_model m;
    lt_onnx_tensor tensor[LIST];
    lt_onnx_node node[LIST];
} script;

static bool take(script *s, char c)
{
    s->at += strspn(s->at, " ");
    if (*s->at != c)
        return false;
    s->at++;
    return true;
}

static const char *take_word(script *s)
{
    const char *from = s->at += strspn(s->at, " ");

    while (isalnum(*s->at) || *s->at == '_')
        s->at++;
    return lt_arena_printf(s->arena, "%.*s", (int)(s->at - from), from);
}

/* Up to the closing mark; the opening one is behind us */
static int take_numbers(script *s, char close, double *out)
{
    int n = 0;

    while (!take(s, close)) {
        char *end;

        ck_assert_int_lt(n, LIST);
        out[n++] = strtod(s->at, &end);
        ck_assert_ptr_ne(end, s->at);
        s->at = end;
        take(s, ',');
    }
    return n;
}

static int64_t *wholes(script *s, const double *x, int n)
{
    int64_t *out = lt_arena_array(s->arena, LIST, sizeof(*out));

    for (int i = 0; i < n; i++)
        out[i] = (int64_t)x[i];
    return out;
}

static const char *add_tensor(script *s, lt_onnx_type type, lt_shape shape, const void *data)
{
    const char *name = lt_arena_printf(s->arena, "constant%d", s->m.n_tensors);

    ck_assert_int_lt(s->m.n_tensors, LIST);
    s->tensor[s->m.n_tensors++] = (lt_onnx_tensor){ name, type, shape, data };
    return name;
}

/* ones(2, 3): reals of this shape */
static const char *take_ones(script *s)
{
    double dim[LIST];
    lt_shape shape = { .rank = take_numbers(s, ')', dim) };
    int64_t n;
    float *x;

    memcpy(shape.dim, wholes(s, dim, shape.rank), sizeof(shape.dim));
    n = lt_shape_numel(&shape);
    x = lt_arena_array(s->arena, (size_t)n, sizeof(*x));
    for (int64_t i = 0; i < n; i++)
        x[i] = 1;
    return add_tensor(s, LT_ONNX_FLOAT, shape, x);
}

/* [1, 2]: whole numbers; #5: one without a dimension; {.5, 1}: reals; ones(2, 3); _: left out; or a value's name */
static const char *take_argument(script *s)
{
    double x[LIST];
    const char *word;
    int n;

    if (take(s, '[')) {
        n = take_numbers(s, ']', x);
        return add_tensor(s, LT_ONNX_INT64, LT_SHAPE(n), wholes(s, x, n));
    }
    if (take(s, '#')) {
        x[0] = (double)strtoll(s->at, (char **)&s->at, 10);
        return add_tensor(s, LT_ONNX_INT64, (lt_shape){ 0 }, wholes(s, x, 1));
    }
    if (take(s, '{')) {
        float *reals = lt_arena_array(s->arena, LIST, sizeof(*reals));

        n = take_numbers(s, '}', x);
        for (int i = 0; i < n; i++)
            reals[i] = (float)x[i];
        return add_tensor(s, LT_ONNX_FLOAT, LT_SHAPE(n), reals);
    }
    word = take_word(s);
    if (take(s, '('))
        return take_ones(s);
    return strcmp(word, "_") == 0 ? "" : word;
}

/* axis=1 alpha=0.5 pads=[1, 1] mode=linear: what it looks like is its kind. */
static lt_onnx_attr take_attr(script *s)
{
    lt_onnx_attr a = { .name = take_word(s), .text = "" };
    char *end;

    ck_assert(take(s, '='));
    if (take(s, '[')) {
        double x[LIST];

        a.kind = LT_ONNX_A_INTS;
        a.n_ints = take_numbers(s, ']', x);
        a.ints = wholes(s, x, a.n_ints);
    } else if (isalpha(*s->at)) {
        a.kind = LT_ONNX_A_TEXT;
        a.text = take_word(s);
    } else {
        a.f = strtof(s->at, &end);
        a.i = (int64_t)a.f;
        a.kind = memchr(s->at, '.', (size_t)(end - s->at)) ? LT_ONNX_A_FLOAT : LT_ONNX_A_INT;
        s->at = end;
    }
    return a;
}

static void take_node(script *s)
{
    lt_onnx_node *n = &s->node[s->m.n_nodes++];

    ck_assert_int_le(s->m.n_nodes, LIST);
    *n = (lt_onnx_node){ .name = "n" };
    n->in = lt_arena_array(s->arena, LIST, sizeof(*n->in));
    n->out = lt_arena_array(s->arena, LIST, sizeof(*n->out));
    n->attr = lt_arena_array(s->arena, LIST, sizeof(*n->attr));
    do
        n->out[n->n_out++] = take_word(s);
    while (take(s, ','));
    ck_assert(take(s, '='));
    n->op = take_word(s);
    for (bool more = take(s, '(') && !take(s, ')'); more; more = !take(s, ')')) {
        n->in[n->n_in++] = take_argument(s);
        take(s, ',');
    }
    while (*s->at && !take(s, ';'))
        n->attr[n->n_attr++] = take_attr(s);
}

/* Of a text: input x of this shape, output y */
static lt_onnx_model *model_of(lt_arena *arena, const char *text, lt_shape shape)
{
    script *s = lt_arena_alloc(arena, sizeof(*s));
    lt_onnx_port *port = lt_arena_array(arena, 2, sizeof(*port));

    *s = (script){ .arena = arena, .at = text, .m = { .opset = 17 } };
    while (*s->at)
        take_node(s);
    port[0] = (lt_onnx_port){ .name = "x", .type = LT_ONNX_FLOAT, .shape = shape };
    port[1] = (lt_onnx_port){ .name = "y", .type = LT_ONNX_FLOAT, .shape = shape };
    s->m.input = &port[0];
    s->m.output = &port[1];
    s->m.n_inputs = s->m.n_outputs = 1;
    s->m.tensor = s->tensor;
    s->m.node = s->node;
    return &s->m;
}

/* ---- what comes out ---------------------------------------------------------------------------------------------- */

/* "(2, 2) 1 2 3 4" of x = 0, 1, 2, ... */
static void run(lt_graph *g, const lt_onnx_ports *ports, char *out, size_t room)
{
    const lt_tensor *y = ports->output[0];
    lt_plan *p = lt_compile(g, NULL);
    char shape[LT_SHAPE_TEXT];
    size_t used;
    lt_real *x;

    ck_assert_msg(p, "%s", lt_last_error());
    x = lt_plan_data(p, ports->input[0]);
    for (int64_t i = 0; i < lt_numel(ports->input[0]); i++)
        x[i] = (lt_real)i;
    lt_run(p);
    used = (size_t)snprintf(out, room, "%s", lt_shape_text(&y->shape, shape));
    for (int64_t i = 0; i < lt_numel(y) && used < room; i++)
        used += (size_t)snprintf(out + used, room - used, " %.4g", (double)((lt_real *)lt_plan_data(p, y))[i]);
    lt_plan_free(p);
}

static const struct {
    const char *text;
    lt_shape x;
    const char *want;
} values[] = {
    /* products */
    { "y = MatMul(x, ones(3, 2))", LT_SHAPE(2, 3), "(2, 2) 3 3 12 12" },
    { "y = MatMul(x, ones(3, 1))", LT_SHAPE(2, 2, 3), "(2, 2, 1) 3 12 21 30" },
    { "y = MatMul(x, ones(2, 3, 1))", LT_SHAPE(2, 2, 3), "(2, 2, 1) 3 12 21 30" },
    { "y = Gemm(x, ones(3, 2))", LT_SHAPE(2, 3), "(2, 2) 3 3 12 12" },
    { "y = Gemm(x, ones(2, 3), {1, 2}) transB=1 alpha=1.0 beta=1.0", LT_SHAPE(2, 3), "(2, 2) 4 5 13 14" },
    { "y = Conv(x, ones(1, 1, 2, 2)) kernel_shape=[2, 2]", LT_SHAPE(1, 1, 2, 3), "(1, 1, 1, 2) 8 12" },
    { "y = Conv(x, ones(1, 1, 1, 1), {1}) strides=[2, 2] pads=[1, 1, 1, 1]", LT_SHAPE(1, 1, 1, 3),
      "(1, 1, 2, 3) 1 1 1 1 1 1" },
    { "y = ConvTranspose(x, ones(1, 1, 2, 2)) strides=[2, 2] kernel_shape=[2, 2]", LT_SHAPE(1, 1, 1, 2),
      "(1, 1, 2, 4) 0 0 1 1 0 0 1 1" },
    /* maps */
    { "y = MaxPool(x) kernel_shape=[2, 2] strides=[2, 2]", LT_SHAPE(1, 1, 2, 3), "(1, 1, 1, 1) 4" },
    { "y = MaxPool(x) kernel_shape=[2, 2] strides=[2, 2] ceil_mode=1", LT_SHAPE(1, 1, 2, 3), "(1, 1, 1, 2) 4 5" },
    { "y = GlobalAveragePool(x)", LT_SHAPE(1, 2, 1, 2), "(1, 2, 1, 1) 0.5 2.5" },
    { "y = Resize(x, _, {1, 1, 2, 2}) coordinate_transformation_mode=asymmetric nearest_mode=floor",
      LT_SHAPE(1, 1, 1, 2), "(1, 1, 2, 4) 0 0 1 1 0 0 1 1" },
    { "y = Resize(x, _, _, [1, 1, 1, 4]) mode=linear", LT_SHAPE(1, 1, 1, 2), "(1, 1, 1, 4) 0 0.25 0.75 1" },
    { "z = Sub(ones(1, 1, 1, 2), ones(1, 1, 1, 2)); y = GridSample(x, z)", LT_SHAPE(1, 1, 3, 3), "(1, 1, 1, 1) 4" },
    { "z = Sub(ones(1, 1, 1, 2), ones(1, 1, 1, 2)); y = GridSample(x, z) mode=linear padding_mode=zeros",
      LT_SHAPE(1, 1, 3, 3), "(1, 1, 1, 1) 4" },
    { "y = RoiAlign(x, ones(1, 4), [0]) coordinate_transformation_mode=output_half_pixel", LT_SHAPE(1, 1, 2, 2),
      "(1, 1, 1, 1) 3" },
    { "i = Cast(x) to=7; l = Reshape(i, [-1]); y = RoiAlign(x, ones(1, 4), l) spatial_scale=1.0 "
      "coordinate_transformation_mode=output_half_pixel", LT_SHAPE(1, 1, 1, 1), "(1, 1, 1, 1) 0" },
    /* norms and single elements */
    { "y = Softmax(x) axis=1", LT_SHAPE(1, 1), "(1, 1) 1" },
    { "y = LayerNormalization(x, {1, 1}, {5, 7}) axis=1 epsilon=1.0e-20", LT_SHAPE(1, 2), "(1, 2) 4 8" },
    { "y = BatchNormalization(x, {2}, {1}, {0}, {4}) epsilon=1.0e-20 training_mode=0", LT_SHAPE(3, 1), "(3, 1) 1 2 3" },
    { "y = Elu(x) alpha=1.0", LT_SHAPE(2), "(2) 0 1" },
    { "y = LeakyRelu(x)", LT_SHAPE(2), "(2) 0 1" },
    { "y = Max(x, {1})", LT_SHAPE(3), "(3) 1 1 2" },
    { "y = Max(x, {nan})", LT_SHAPE(2), "(2) nan nan" },
    { "y = Max({nan, 5}, x)", LT_SHAPE(2), "(2) nan 5" },
    { "y = Div(x, {2})", LT_SHAPE(3), "(3) 0 0.5 1" },
    { "y = Div(x, {2})", LT_SHAPE(0, 3), "(0, 3)" },
    { "s = Sqrt(x); y = Erf(s)", LT_SHAPE(2), "(2) 0 0.8427" },
    { "y = Softmax(x) axis=0", LT_SHAPE(1, 2), "(1, 2) 1 1" },
    { "y = Where([0, 1], x, {nan})", LT_SHAPE(2), "(2) nan 1" },
    { "y = Pow(x, {2})", LT_SHAPE(3), "(3) 0 1 4" },
    { "i = Cast(x) to=7; p = Pow(i, {-1}); y = Cast(p) to=1", LT_SHAPE(3), "(3) inf 1 0" },
    { "y = Clip({nan}, {0}, {1}); z = Relu(x)", LT_SHAPE(1), "(1) nan" },
    { "y = HardSigmoid({nan}); z = Relu(x)", LT_SHAPE(1), "(1) nan" },
    /* shapes */
    { "y = Reshape(x, [0, -1])", LT_SHAPE(2, 3, 1), "(2, 3) 0 1 2 3 4 5" },
    { "y = Reshape(x, [-1])", LT_SHAPE(2, 1), "(2) 0 1" },
    { "y = Reshape(ones(2), [1, 2])", LT_SHAPE(1), "(1, 2) 1 1" },
    { "y = Flatten(x)", LT_SHAPE(1, 2, 2), "(1, 4) 0 1 2 3" },
    { "s = ReduceSum(x, [0]) keepdims=0; y = Flatten(s) axis=1", LT_SHAPE(3), "(1, 1) 3" },
    { "y = Squeeze(x)", LT_SHAPE(1, 2, 1), "(2) 0 1" },
    { "y = Transpose(x)", LT_SHAPE(2, 3), "(3, 2) 0 3 1 4 2 5" },
    { "y = Transpose(x) perm=[0, 2, 1]", LT_SHAPE(1, 2, 2), "(1, 2, 2) 0 2 1 3" },
    { "y = Concat(x, x) axis=-1", LT_SHAPE(2, 1), "(2, 2) 0 0 1 1" },
    { "y = Slice(x, [-2], [100])", LT_SHAPE(3), "(2) 1 2" },
    { "y = Slice(x, [-9, 1], [-1, 2], [-1, 0])", LT_SHAPE(2, 3), "(1, 2) 3 4" },
    { "y = Slice(x, [1], [2], _)", LT_SHAPE(3), "(1) 1" },
    { "y = Gather(x, [-1, 0]) axis=1", LT_SHAPE(2, 2), "(2, 2) 1 0 3 2" },
    { "y = ReduceSum(x, [-1])", LT_SHAPE(2, 2), "(2, 1) 1 5" },
    { "y = ReduceSum(x, [0]) keepdims=0", LT_SHAPE(2, 2), "(2) 2 4" },
    { "i = Cast(x) to=6; y = Cast(i) to=1", LT_SHAPE(2), "(2) 0 1" },
    { "h = Div(x, {2}); y = Cast(h) to=7", LT_SHAPE(4), "(4) 0 0 1 1" },
    /* whole numbers are divided towards zero, whatever stands between them and the cast that made them */
#define DIVIDED(step) "n = Sub(x, {3}); i = Cast(n) to=7; s = " step "; d = Div(s, [2]); y = Cast(d) to=1"
    { DIVIDED("Identity(i)"), LT_SHAPE(6), "(6) -1 -1 0 0 0 1" },
    { DIVIDED("Transpose(i)"), LT_SHAPE(2, 3), "(3, 2) -1 0 -1 0 0 1" },
    { DIVIDED("Reshape(i, [-1, 1])"), LT_SHAPE(2), "(2, 1) -1 -1" },
    { DIVIDED("Flatten(i)"), LT_SHAPE(1, 2, 1), "(1, 2) -1 -1" },
    { DIVIDED("Squeeze(i)"), LT_SHAPE(1, 2), "(2) -1 -1" },
    { DIVIDED("Slice(i, [0], [1])"), LT_SHAPE(6), "(1) -1" },
    { DIVIDED("Concat(i, i) axis=0"), LT_SHAPE(1), "(2) -1 -1" },
    { DIVIDED("Gather(i, [0, 5]) axis=0"), LT_SHAPE(6), "(2) -1 1" },
    { DIVIDED("ReduceSum(i, [0]) keepdims=0"), LT_SHAPE(2, 1), "(1) -2" },
    { DIVIDED("Relu(i)"), LT_SHAPE(9), "(9) 0 0 0 0 0 1 1 2 2" },
    { DIVIDED("Max(i, [-1])"), LT_SHAPE(2), "(2) 0 0" },
    { DIVIDED("Mul(i, i)"), LT_SHAPE(2), "(2) 4 2" },
    { DIVIDED("MatMul(i, i)"), LT_SHAPE(1, 1), "(1, 1) 4" },
#undef DIVIDED
    { "i = Cast(x) to=7; t = Cast({2}) to=7; d = Div(i, t); y = Cast(d) to=1", LT_SHAPE(4), "(4) 0 0 1 1" },
    { "i = Cast(x) to=7; r = Cast(i) to=1; y = Div(r, {2})", LT_SHAPE(4), "(4) 0 0.5 1 1.5" },
    /* known numbers */
    { "s = Shape(x); l = Cast(s) to=7; f = Cast(l) to=1; y = Relu(f)", LT_SHAPE(4, 5, 6), "(3) 4 5 6" },
    { "s = Shape(x) start=1 end=-1; f = Cast(s) to=1; y = Relu(f)", LT_SHAPE(4, 5, 6), "(1) 5" },
    { "s = Shape(x) start=-1; f = Cast(s) to=1; y = Relu(f)", LT_SHAPE(4, 5, 6), "(1) 6" },
    { "s = Shape(x) start=2 end=1; f = Cast(s) to=1; y = Relu(f)", LT_SHAPE(4, 5, 6), "(0)" },
    { "c = Concat([7], [], [-8, 9]) axis=0; f = Cast(c) to=1; n = Relu(f); y = Sub(n, {1})", LT_SHAPE(1),
      "(3) 6 -1 8" },
    { "m = Max([3], [-1], [5]); n = Min(m, [9]); s = Sub(n, [7]); f = Cast(s) to=1; y = Relu(f)", LT_SHAPE(1),
      "(1) 0" },
    { "d = Div([7, -7, 7, -7], [2, 2, -2, -2]); f = Cast(d) to=1; y = Sub(f, {0})", LT_SHAPE(1), "(4) 3 -3 -3 3" },
    { "d = Div(#-9223372036854775808, [-1]); f = Cast(d) to=1; y = Sub(f, {0})", LT_SHAPE(1), "(1) -9.223e+18" },
    { "b = Cast([0, 3]) to=9; f = Cast(b) to=1; y = Sub(f, {0})", LT_SHAPE(1), "(2) 0 1" },
    { "s = Slice([4, 5, 6, 7], [-1], [-9], _, [-2]); f = Cast(s) to=1; y = Sub(f, {0})", LT_SHAPE(1), "(2) 7 5" },
    { "r = Range(#0, #3, #1); i = Identity(r); f = Cast(i) to=1; y = Relu(f)", LT_SHAPE(1), "(3) 0 1 2" },
};

START_TEST(computes)
{
    lt_arena *arena = lt_arena_new();
    lt_onnx_ports ports;
    lt_graph *g = lt_graph_new();
    char got[256];

    check_ok(lt_onnx_import(arena, g, model_of(arena, values[_i].text, values[_i].x), 1, &ports));
    run(g, &ports, got, sizeof(got));
    ck_assert_msg(strcmp(got, values[_i].want) == 0, "%s: %s, want %s", values[_i].text, got, values[_i].want);
    lt_graph_free(g);
    lt_arena_free(arena);
}
END_TEST

#define NEAREST " coordinate_transformation_mode=asymmetric nearest_mode=floor"
#define ROI " coordinate_transformation_mode=output_half_pixel"
#define MAP LT_SHAPE(1, 1, 2, 2)

static const struct {
    const char *text;
    lt_shape x;
    const char *reason;
} refusals[] = {
    /* products */
    { "s = ReduceSum(x, [0]) keepdims=0; y = MatMul(s, ones(1, 1))", LT_SHAPE(3), "too few dimensions" },
    { "y = MatMul(x, [1, 2])", LT_SHAPE(2), "input 1 holds whole numbers, want reals" },
    { "y = Gemm(x, ones(1, 3, 2))", LT_SHAPE(2, 3), "an operand has not 2 dimensions" },
    { "y = Gemm(x, ones(3, 2))", LT_SHAPE(1, 2, 3), "an operand has not 2 dimensions" },
    { "y = Gemm([1], ones(3, 2))", LT_SHAPE(2, 3), "input 0 holds whole numbers" },
    { "y = Conv(x, ones(1, 1, 1, 1)) kernel_shape=[2, 1]", MAP, "\"kernel_shape\" is not the weight's" },
    { "y = Conv(x, ones(1, 1, 1, 1)) kernel_shape=[1, 2]", MAP, "\"kernel_shape\" is not the weight's" },
    { "y = Conv(x, ones(1, 1, 1, 1)) kernel_shape=[1, 1, 1]", MAP, "\"kernel_shape\" is not the weight's" },
    { "y = Conv(x, ones(1, 1, 1, 1)) kernel_shape=1", MAP, "\"kernel_shape\" is not the weight's" },
    { "y = Conv(x, ones(1, 1, 1)) kernel_shape=[1, 1]", MAP, "\"kernel_shape\" is not the weight's" },
    { "y = Conv(x, [1]) kernel_shape=[1, 1]", MAP, "input 1 holds whole numbers" },
    { "y = Conv(x, ones(1, 1, 1, 1)) strides=[1, 2]", MAP, "\"strides\" has numbers that differ" },
    { "y = Conv(x, ones(1, 1, 1, 1)) strides=[1]", MAP, "\"strides\" has 1 numbers, want 2" },
    { "y = Conv(x, ones(1, 1, 1, 1)) strides=[]", MAP, "\"strides\" has 0 numbers, want 2" },
    { "y = Conv(x, ones(1, 1, 1, 1)) group=0", MAP, "\"group\" is 0, want 1 to" },
    { "y = ConvTranspose(x, ones(1, 1, 1, 1)) group=2", MAP, "\"group\" is 2, want 1 to 1" },
    { "y = ConvTranspose(x, ones(1, 1, 1, 1)) dilations=[2, 2]", MAP, "\"dilations\" is 2, want 1 to 1" },
    { "y = ConvTranspose(x, [1])", MAP, "input 1 holds whole numbers" },
    /* maps */
    { "y = MaxPool([1]) kernel_shape=[1, 1]", MAP, "input 0 holds whole numbers" },
    { "y = GlobalAveragePool(x)", LT_SHAPE(1, 2, 2), "its input has 3 dimensions, want 4" },
    { "y = GlobalAveragePool([1])", MAP, "input 0 holds whole numbers" },
    { "y = Resize(x, _, {2, 1, 2, 2})" NEAREST, MAP, "scales are not 1, 1 and twice a whole number" },
    { "y = Resize(x, _, {1, 2, 2, 2})" NEAREST, MAP, "scales are not" },
    { "y = Resize(x, _, {1, 1, 2, 3})" NEAREST, MAP, "scales are not" },
    { "y = Resize(x, _, {1, 1, .5, .5})" NEAREST, MAP, "scales are not" },
    { "y = Resize(x, _, {1, 1, 1.5, 1.5})" NEAREST, MAP, "scales are not" },
    { "y = Resize(x, _, {1, 1, 2000, 2000})" NEAREST, MAP, "scales are not" },
    { "y = Resize(x, _, {1, 1, nan, nan})" NEAREST, MAP, "scales are not" },
    { "y = Resize(x, _, {2, 2})" NEAREST, MAP, "scales are not" },
    { "y = Resize(x)" NEAREST, MAP, "scales are not" },
    { "y = Resize(x, _, {1, 1, 2, 2}) nearest_mode=floor", MAP,
      "\"nearest\" is read with \"asymmetric\" and \"floor\"" },
    { "y = Resize(x, _, {1, 1, 2, 2}) coordinate_transformation_mode=asymmetric", MAP, "\"nearest\" is read with" },
    { "y = Resize(x, _, _, [1, 1, 4, 4]) mode=cubic", MAP, "\"linear\" with \"half_pixel\" or \"nearest\" is read" },
    { "y = Resize(x, _, _, [1, 1, 4, 4]) mode=linear coordinate_transformation_mode=align_corners", MAP,
      "\"linear\" with \"half_pixel\"" },
    { "y = Resize(x, _, _, [4, 4]) mode=linear", MAP, "want a size for the last two of four dimensions" },
    { "y = Resize(x, _, _, [2, 1, 4, 4]) mode=linear", MAP, "want a size for the last two" },
    { "y = Resize(x, _, _, [1, 2, 4, 4]) mode=linear", MAP, "want a size for the last two" },
    { "y = Resize(x, _, _, [1, 1, 4, 4]) mode=linear", LT_SHAPE(1, 1, 2), "want a size for the last two" },
    { "y = Resize([1])", MAP, "input 0 holds whole numbers" },
    { "y = GridSample(x, ones(1, 1, 1, 2)) mode=nearest", MAP, "\"bilinear\" with \"zeros\" is read" },
    { "y = GridSample(x, ones(1, 1, 1, 2)) padding_mode=border", MAP, "\"bilinear\" with \"zeros\" is read" },
    { "y = GridSample(x, ones(1, 1, 1, 2)) align_corners=1", MAP, "\"align_corners\" is 1, want 0 to 0" },
    { "y = GridSample(x, [1])", MAP, "input 1 holds whole numbers" },
    { "y = RoiAlign(x, ones(1, 4), [0])", MAP, "\"avg\" with \"output_half_pixel\" is read" },
    { "y = RoiAlign(x, ones(1, 4), [0]) mode=max" ROI, MAP, "\"avg\" with \"output_half_pixel\" is read" },
    { "y = RoiAlign(x, ones(1, 4), #0)" ROI, MAP, "images' indices are no list" },
    { "y = RoiAlign(x, ones(1, 4), {0})" ROI, MAP, "images' indices are no whole numbers" },
    { "y = RoiAlign(x, [1], [0])" ROI, MAP, "input 1 holds whole numbers" },
    { "y = RoiAlign(x, ones(1, 4), [0]) sampling_ratio=2" ROI, MAP, "\"sampling_ratio\" is 2, want 0 to 0" },
    /* norms and single elements */
    { "y = Softmax([1])", MAP, "input 0 holds whole numbers" },
    { "y = LayerNormalization(x, {1, 1}, {0, 0}) axis=0", LT_SHAPE(2, 2),
      "its weights are not of the shape that is normalised" },
    { "y = LayerNormalization(x, {1, 1}, [1])", LT_SHAPE(2, 2), "input 2 holds whole numbers" },
    { "y = BatchNormalization(x, {1}, {0}, {0}, {1}) training_mode=1", MAP, "\"training_mode\" is 1, want 0 to 0" },
    { "y = Elu(x) alpha=0.5", MAP, "\"alpha\" is not 1" },
    { "y = Elu(x) alpha=1", MAP, "\"alpha\" is of kind 2, want 1" },
    { "y = LeakyRelu([1])", MAP, "input 0 holds whole numbers" },
    { "y = Tanh([1])", MAP, "input 0 holds whole numbers" },
    { "y = Sub([1], x)", MAP, "input 0 holds whole numbers" },
    { "y = Sub(x, [1])", MAP, "input 1 holds whole numbers" },
    /* shapes */
    { "y = Reshape(x, [-1, -1])", MAP, "the new shape cannot be" },
    { "y = Reshape(x, [-2, 2])", MAP, "the new shape cannot be" },
    { "y = Reshape(x, [3000000000])", MAP, "the new shape cannot be" },
    { "y = Reshape(x, [2147483647, 2147483647, 3])", MAP, "the new shape cannot be" },
    { "y = Reshape(x, [2147483647, 2147483647, 2147483647])", MAP, "the new shape cannot be" },
    { "y = Reshape(x, [3, -1])", MAP, "4 elements do not fill the new shape" },
    { "y = Reshape(x, [0, -1])", LT_SHAPE(0, 2), "0 elements do not fill the new shape" },
    { "y = Reshape(x, [0, 4, 1, 1, 0])", MAP, "the new shape has 0 elements, want 4" },
    { "y = Transpose(x) perm=[0, 1]", LT_SHAPE(1, 2, 3), "\"perm\" is no list of 3 dimensions" },
    { "y = Transpose(x) perm=1", LT_SHAPE(1), "\"perm\" is no list of 1 dimensions" },
    { "y = Transpose(x) perm=[0, 6]", LT_SHAPE(1, 2), "is no permutation" },
    { "y = Transpose([1])", MAP, "input 0 holds whole numbers" },
    { "y = Concat([1], #2) axis=0", MAP, "input 1 is no list" },
    { "y = Concat([1], x) axis=0", MAP, "input 1 is not known before the model runs" },
    { "y = Slice(x, [0], [1, 2])", MAP, "1 starts and 2 ends" },
    { "y = Slice(x, [0], [1], [0, 1])", MAP, "1 starts and 1 ends" },
    { "y = Slice(x, [], [])", MAP, "0 starts and 0 ends" },
    { "y = Slice(x, [0], [1], [4])", MAP, "axis 4 of 4 dimensions" },
    { "y = Slice(x, [0], [1], [-5])", MAP, "axis -5 of 4 dimensions" },
    { "y = Slice(#2, [0], [1])", MAP, "axis 0 of 0 dimensions" },
    { "y = Gather(x, [2])", LT_SHAPE(2, 2), "index 2 of 2 elements" },
    { "y = Gather(x, [-3])", LT_SHAPE(2, 2), "index -3 of 2 elements" },
    { "y = Gather(x, [2147483648])", LT_SHAPE(3000000000), "index 2147483648 of 3000000000 elements" },
    { "y = Gather(#1, [0])", MAP, "\"axis\" is 0, want 0 to -1" },
    { "y = ReduceSum(x, [4])", MAP, "axis 4 of 4 dimensions" },
    { "y = ReduceSum(x, [-5])", MAP, "axis -5 of 4 dimensions" },
    { "y = ReduceSum([1], [0])", MAP, "input 0 holds whole numbers" },
    { "y = Range(#1, #3, #1)", MAP, "from 1 to 3 by 1; from 0 to 1048576 at most by 1 is read" },
    { "y = Range(#0, #3, #2)", MAP, "from 0 to 3 by 2" },
    { "y = Range(#0, #-3, #1)", MAP, "from 0 to -3 by 1" },
    { "y = Range(#0, #1048577, #1)", MAP, "from 0 to 1048577 by 1" },
    { "y = Range(#0, [3, 4], #1)", MAP, "input 1 is not one number" },
    { "a = Range(#0, #1048576, #1); b = Concat(a, a) axis=0; y = Concat(b, b) axis=0", MAP,
      "Concat \"n\": 4194304 known numbers, more than 4194304 with those of the nodes before" },
    { "a = Range(#0, #1048576, #1); b = Cast(a) to=1; c = Cast(a) to=1; d = Gather(x, a) axis=3; y = Cast(a) to=1",
      LT_SHAPE(1, 1, 1, 1048576), "Cast \"n\": 1048576 known numbers, more than 4194304" },
    { "y = Shape(x) end=5", MAP, "\"end\" is 5, want -4 to 4" },
    { "y = Cast(x) to=11", MAP, "to type 11; 1 (FLOAT), 6 (INT32), 7 (INT64), 9 (BOOL) are read" },
    { "y = Cast(x)", MAP, "\"to\" is 0, want 1 to" },
    /* what must be the default is named with it */
    { "y = Conv(x, ones(1, 1, 1, 1)) auto_pad=SAME", MAP, "\"auto_pad\" is \"SAME\"; NOTSET, VALID" },
    { "y = Conv(x, ones(1, 1, 1, 1)) pads=[1, 1]", MAP, "\"pads\" has 2 numbers, want 4" },
    { "y = Conv(x, ones(1, 1, 1, 1)) pads=[0, 0, -1, 0]", MAP, "\"pads\" is -1, want 0 to" },
    { "y = ConvTranspose(x, ones(1, 1, 1, 1)) output_padding=[0, 1]", MAP,
      "\"output_padding\" says something else than 0, which is all that is read" },
    { "y = ConvTranspose(x, ones(1, 1, 1, 1)) auto_pad=VALID", MAP, "\"auto_pad\" says something else than NOTSET" },
    { "y = MaxPool(x) kernel_shape=[2, 2] dilations=[2, 2]", MAP, "\"dilations\" says something else than 1" },
    { "y = MaxPool(x) kernel_shape=[2, 2] storage_order=1", MAP, "\"storage_order\" says something else than 0" },
    { "y = MaxPool(x) kernel_shape=[2, 2] pads=[1, 0, 0, 0] ceil_mode=1", MAP,
      "\"ceil_mode\" with borders that differ" },
    { "y = LayerNormalization(x, {1, 1}) stash_type=10", MAP, "\"stash_type\" says something else than 1" },
    { "y = Gelu(x) approximate=tanh", MAP, "\"approximate\" says something else than none" },
    { "y = Clip(x, ones(2))", MAP, "a bound is not one number" },
    { "y = Clip(x, [1])", MAP, "input 1 holds whole numbers" },
    { "y = Gemm(x, ones(3, 2), ones(3, 1)) beta=2.0", LT_SHAPE(2, 3), "(2, 2) and (3, 1) do not broadcast" },
    { "y = Gemm(x, ones(3, 2), ones(2, 1, 1))", LT_SHAPE(2, 3), "what is added does not stretch to the product" },
    { "y = MatMul(x, ones(3, 3, 1))", LT_SHAPE(2, 2, 3), "(2) and (3) do not broadcast" },
    { "y = Resize(x, _, {1, 1, 1.3, 1.3}) mode=linear", MAP, "a size of 2.6" },
    { "y = Resize(x, _, _, [1, 1, 1, 4]) mode=linear coordinate_transformation_mode=pytorch_half_pixel", MAP,
      "a size of 1" },
    { "y = Squeeze(x, [2])", MAP, "dimension 2 is 2, want 1" },
    { "y = Unsqueeze(x, [0, 0])", MAP, "axis 0 of 6 dimensions, or twice" },
    { "y = Unsqueeze(x, [0, 1, 2])", MAP, "4 and 3 dimensions, at most 6 are possible" },
    { "y = Unsqueeze(x)", MAP, "input 1 is not known" },
    { "y = Reshape(x, [0, -1]) allowzero=1", MAP, "4 elements do not fill the new shape" },
    { "y = Slice(x, [0], [1], [0], [0])", MAP, "a step of 0" },
    { "y = Slice(x, [0], [1], [0], [1, 1])", MAP, "1 starts and 1 ends" },
    { "y, z = Split(x, [1, 2]) axis=3", MAP, "its pieces are not the 2 elements of axis 3" },
    { "y, z = Split(x, [-1, 3]) axis=3", MAP, "its pieces are not the 2 elements" },
    { "y, z = Split(x, [2]) axis=3", MAP, "1 lengths for 2 results" },
    { "y, z = Split(x) axis=3 num_outputs=3", MAP, "\"num_outputs\" is 3, want 2 to 2" },
    { "y = Pad(x, [1, 1])", MAP, "2 borders of 4 dimensions" },
    { "y = Pad(x, [0, 0, 2, 0, 0, 0, 0, 0]) mode=reflect", MAP, "has none to mirror for a border of 2" },
    { "y = Pad(x, [0, 0, -3, 0, 0, 0, 0, 0])", MAP, "dimension 2 of 2 elements has no border of -3 and 0" },
    { "y = Pad(x, [0, 0, 2000000, 0, 0, 0, 0, 0])", MAP, "borders that cannot be" },
    { "y = Pad(x, [1, 1], _, [4])", MAP, "borders that cannot be" },
    { "y = Pad(x, [0, 0, 0, 0, 0, 0, 0, 0]) mode=wrap", MAP,
      "\"mode\" is \"wrap\"; constant, edge and reflect are read" },
    { "y = Pad(x, [0, 0, 0, 0, 0, 0, 0, 0], x)", MAP, "is not one number that is known" },
    { "y = Expand(x, [-1, 1])", MAP, "a dimension of -1" },
    { "y = Expand(x, [1, 1, 1, 1, 1, 1, 1])", MAP, "7 dimensions, at most 6 are possible" },
    { "y = Expand(x, [3])", MAP, "(1, 1, 2, 2) and (3) do not broadcast" },
    { "y = Expand(x, [2147483647, 2147483647, 2147483647, 1, 1])", MAP, "too large" },
    { "a = Expand([1, 1], [2147483647, 2]); y = Relu(x)", MAP, "4294967294 known numbers, more than 4194304" },
    { "y = ConstantOfShape([4194305])", MAP, "4194305 known numbers, more than 4194304" },
    { "a = Range(#0, #1048576, #1); b = Reshape(a, [-1, 1]); c = Reshape(a, [1, 1, 1, -1]); d = Add(a, b); "
      "y = Add(d, c)", MAP,
      "1099511627776 known numbers, more than" },
    { "y = ConstantOfShape([2]) value=1", MAP, "\"value\" is no tensor of one element" },
    { "y = Constant() value_int=1 value_float=1.0", MAP, "2 attributes, want one that holds its value" },
    { "y = Dropout(x, {.5}, x)", MAP, "is told to train" },
    { "y = Div([4], [0])", MAP, "a division by 0" },
    { "y = Equal([1, 2], [1, 2, 3])", MAP, "(2) and (3) do not broadcast" },
    /* the graph around them */
    { "y, z = Relu(x)", MAP, "2 results, want one" },
    { "y = Relu(x) a234567890123456789012345678901234567890123456789012345678901=1", MAP, "is not understood" },
    { "z = Relu(x)", MAP, "output \"y\" is no result of the graph" },
    { "y = Identity([1])", MAP, "output \"y\" is no result of the graph" },
    { "x = Relu(x); y = Relu(x)", MAP, "value \"x\" is made twice" },
};

START_TEST(refuses)
{
    lt_arena *arena = lt_arena_new();
    lt_onnx_ports ports;
    lt_graph *g = lt_graph_new();

    ck_assert_msg(lt_onnx_import(arena, g, model_of(arena, refusals[_i].text, refusals[_i].x), 1, &ports) == LT_EFORMAT,
                  "%s", refusals[_i].text);
    ck_assert_msg(strstr(lt_last_error(), refusals[_i].reason), "\"%s\" lacks \"%s\"", lt_last_error(),
                  refusals[_i].reason);
    ck_assert_msg(!strstr(lt_last_error(), ".c:"), "\"%s\" names a line of ours", lt_last_error());
    lt_graph_free(g);
    lt_arena_free(arena);
}
END_TEST

START_TEST(one_value_is_one_output)
{
    lt_arena *arena = lt_arena_new();
    lt_onnx_model *m = model_of(arena, "y = Relu(x)", MAP);
    lt_onnx_port twice[2] = { m->output[0], m->output[0] };
    lt_graph *g = lt_graph_new();
    lt_onnx_ports ports;

    m->output = twice;
    m->n_outputs = 2;
    check_error(lt_onnx_import(arena, g, m, 1, &ports), LT_EFORMAT, "output \"y\" is another output too");
    lt_graph_free(g);
    lt_arena_free(arena);
}
END_TEST

/* What has no memory says so; it is no mistake of the file's. */
/* Before set 16 RoiAlign had no attribute for its half pixel, and none. */
START_TEST(defaults_of_older_sets)
{
    lt_arena *arena = lt_arena_new();
    lt_onnx_model *m = model_of(arena, "y = RoiAlign(x, ones(1, 4), [0])", MAP);
    lt_graph *g = lt_graph_new();
    lt_onnx_ports ports;

    m->opset = 15;
    check_ok(lt_onnx_import(arena, g, m, 1, &ports));
    lt_graph_free(g);
    lt_arena_free(arena);
}
END_TEST

/* Softmax went over all dimensions from its axis on before set 13, and its axis was another. */
START_TEST(softmax_of_older_sets)
{
    lt_arena *arena = lt_arena_new();
    lt_onnx_model *m = model_of(arena, "y = Softmax(ones(1, 2, 2)); z = Relu(x)", LT_SHAPE(1));
    lt_graph *g = lt_graph_new();
    lt_onnx_ports ports;
    char got[256];

    m->opset = 12;
    check_ok(lt_onnx_import(arena, g, m, 1, &ports));
    run(g, &ports, got, sizeof(got));
    ck_assert_str_eq(got, "(1, 2, 2) 0.25 0.25 0.25 0.25");
    lt_graph_free(g);
    lt_arena_free(arena);
}
END_TEST

/* Only a dimension that is the batch's becomes the batch. */
static const struct {
    int64_t dim[4];
    const char *open[4], *reason;       /* NULL: read, with batch 5 for what is open */
} opened[] = {
    { { -1, 3, 8, 8 }, { "batch" }, NULL },
    { { -1, 3, 8, 8 }, { NULL }, NULL },
    { { -1, 3, -1, 8 }, { "n", NULL, "n" }, NULL },
    { { -1, 3, -1, -1 }, { "batch", NULL, "height", "width" }, "dimension 2 (\"height\") is open" },
    { { 1, 3, 8, -1 }, { NULL, NULL, NULL, "w" }, "dimension 3 (\"w\") is open, which only the batch may be" },
    { { -1, 3, -1, 8 }, { NULL }, "dimension 2 (\"\") is open" },
    { { -1, -1, 3, 1 }, { "in_Height", "in_Width" }, "dimension 0 (\"in_Height\") is open" },
    { { -1, 3, 8, 8 }, { "H" }, "dimension 0 (\"H\") is open" },
};

START_TEST(open_dimensions)
{
    lt_arena *arena = lt_arena_new();
    lt_shape shape = { .rank = 4 };
    lt_onnx_model *m;
    lt_graph *g = lt_graph_new();
    lt_onnx_ports ports;

    memcpy(shape.dim, opened[_i].dim, sizeof(opened[_i].dim));
    m = model_of(arena, "y = Relu(x)", shape);
    memcpy(m->input[0].open, opened[_i].open, sizeof(opened[_i].open));
    if (opened[_i].reason) {
        check_error(lt_onnx_import(arena, g, m, 5, &ports), LT_EFORMAT, opened[_i].reason);
    } else {
        check_ok(lt_onnx_import(arena, g, m, 5, &ports));
        for (int i = 0; i < 4; i++)
            ck_assert_int_eq(ports.input[0]->shape.dim[i], shape.dim[i] < 0 ? 5 : shape.dim[i]);
    }
    lt_graph_free(g);
    lt_arena_free(arena);
}
END_TEST

static lt_status import_without_memory(const lt_onnx_model *m, int room, long fail_at)
{
    lt_arena *arena = arena_with_room(room);
    lt_graph *g = lt_graph_new();
    lt_onnx_ports ports;
    lt_status st;

    lt_alloc_fail_at(fail_at);
    st = lt_onnx_import(arena, g, m, 1, &ports);
    lt_alloc_fail_at(0);
    ck_assert_msg(st == LT_OK || st == LT_ENOMEM, "room %d, allocation %ld: %s", room, fail_at, lt_last_error());
    lt_graph_free(g);
    lt_arena_free(arena);
    return st;
}

START_TEST(without_memory)
{
    lt_arena *arena = lt_arena_new();
    const lt_onnx_model *m = model_of(arena, values[_i].text, values[_i].x);

    for (int room = 0; room < 40; room++)
        for (long at = 1; import_without_memory(m, room, at); at++)
            ck_assert_int_lt(at, 100);
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_loop_test(tc, computes, 0, LT_COUNT(values));
    tcase_add_loop_test(tc, refuses, 0, LT_COUNT(refusals));
    tcase_add_test(tc, one_value_is_one_output);
    tcase_add_test(tc, defaults_of_older_sets);
    tcase_add_test(tc, softmax_of_older_sets);
    tcase_add_loop_test(tc, open_dimensions, 0, LT_COUNT(opened));
    tcase_add_loop_test(tc, without_memory, 0, LT_COUNT(values));
}

int main(void)
{
    return run_suite("onnx_rules", add_tests);
}
