/* SPDX-License-Identifier: Apache-2.0 */
/* ONNX files: a graph written and read back; files of other writers; hostile ones. That every model survives
 * the way is tests/eval/test_export. */
#include "libtensor/graph/plan.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/file.h"
#include "libtensor/io/onnx/fields.h"
#include "libtensor/io/onnx/onnx.h"
#include "libtensor/io/protobuf.h"
#include "libtensor/ops/ops.h"
#include "tests/io/hostile.h"

#include <math.h>

/* ---- a file of our own ---------------------------------------------------------------------------------------- */

static void fill(lt_real *x, int64_t n, uint64_t stream)
{
    lt_rng rng = lt_rng_make(1, stream);

    for (int64_t i = 0; i < n; i++)
        x[i] = (lt_real)lt_rng_normal(&rng);
}

/* y (batch, 2, 12) of x (batch, 3, 5, 7) */
static lt_tensor *record_small(lt_tensor *x)
{
    lt_graph *g = x->graph;
    lt_real w[2 * 3 * 3 * 3], b[2];
    lt_tensor *y;

    fill(w, LT_COUNT(w), 1);
    fill(b, LT_COUNT(b), 2);
    y = lt_conv2d(x, lt_constant(g, LT_F32, LT_SHAPE(2, 3, 3, 3), w), lt_constant(g, LT_F32, LT_SHAPE(2), b),
                  &(lt_conv_opts){ .pad = 1 });
    y = lt_max_pool2d(lt_leaky_relu(y, 0.1), 3, 2, 1, false);
    y = lt_softmax(lt_reshape(y, LT_SHAPE(lt_dim(x, 0), 2, 12)));
    return lt_output(lt_scale(y, 3), "y");
}

static lt_tensor *small_input(int64_t batch)
{
    return lt_input(lt_graph_new(), "x", LT_F32, 4, (int64_t[]){ batch, 3, 5, 7 });
}

/* The bytes of the graph for any batch, in memory of the arena */
static uint8_t *small_file(lt_arena *arena, size_t *n)
{
    lt_tensor *x = small_input(1), *twin = small_input(2);
    lt_onnx_model m;
    uint8_t *copy;
    char *bytes;
    FILE *f = open_memstream(&bytes, n);

    record_small(x);
    record_small(twin);
    check_ok(lt_onnx_describe(arena, x->graph, twin->graph, &m));
    check_ok(lt_onnx_write(f, "small", &m));
    fclose(f);
    copy = lt_arena_alloc(arena, *n);
    memcpy(copy, bytes, *n);
    free(bytes);
    lt_graph_free(x->graph);
    lt_graph_free(twin->graph);
    return copy;
}

START_TEST(what_is_written_is_read)
{
    lt_arena *arena = lt_arena_new();
    lt_onnx_model m;
    size_t n;
    uint8_t *bytes = small_file(arena, &n);

    check_ok(lt_onnx_parse(arena, "small", bytes, n, &m));
    ck_assert_int_eq(m.opset, 17);
    ck_assert_int_eq(m.n_inputs, 1);
    ck_assert_str_eq(m.input[0].name, "x");
    ck_assert_int_eq(m.input[0].shape.dim[0], -1);
    ck_assert_int_eq(m.input[0].shape.dim[3], 7);
    ck_assert_int_eq(m.n_outputs, 1);
    ck_assert_str_eq(m.output[0].name, "y");
    ck_assert_int_eq(m.n_nodes, 6);
    ck_assert_str_eq(m.node[0].op, "Conv");
    ck_assert_int_eq(m.node[0].n_in, 3);
    ck_assert_str_eq(m.node[1].op, "LeakyRelu");
    ck_assert_float_eq(m.node[1].attr[0].f, 0.1f);
    ck_assert_str_eq(m.node[2].op, "MaxPool");
    ck_assert_str_eq(m.node[2].attr[0].name, "kernel_shape");
    ck_assert_int_eq(m.node[2].attr[0].n_ints, 2);
    ck_assert_int_eq(m.node[2].attr[0].ints[1], 3);
    ck_assert_str_eq(m.node[5].out[0], "y");
    lt_arena_free(arena);
}
END_TEST

static lt_real *run(lt_plan **p, lt_tensor *x, const lt_tensor *y, const lt_real *values)
{
    *p = lt_compile(x->graph, NULL);
    ck_assert_msg(*p, "%s", lt_last_error());
    memcpy(lt_plan_data(*p, x), values, lt_nbytes(x));
    lt_run(*p);
    return lt_plan_data(*p, y);
}

/* In a plan outputs are known by their tensors; in a file by their names. */
START_TEST(two_ports_of_one_name)
{
    lt_arena *arena = lt_arena_new();
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 1, (int64_t[]){ 3 });
    lt_onnx_model m;

    lt_output(lt_relu(x), "y");
    lt_output(lt_tanh(x), _i ? "x" : "y");
    check_error(lt_onnx_describe(arena, g, NULL, &m), LT_EINVAL,
                _i ? "two inputs or outputs are called \"x\"" : "two inputs or outputs are called \"y\"");
    lt_graph_free(g);
    lt_arena_free(arena);
}
END_TEST

START_TEST(a_file_runs_for_any_batch)
{
    lt_arena *arena = lt_arena_new();
    lt_onnx_ports ports;
    lt_onnx_model m;
    size_t n;
    uint8_t *bytes = small_file(arena, &n);

    check_ok(lt_onnx_parse(arena, "small", bytes, n, &m));
    for (int64_t batch = 1; batch < 6; batch += 2) {
        lt_tensor *ours = small_input(batch), *y = record_small(ours);
        lt_real values[5 * 105], *a, *b;
        lt_graph *g = lt_graph_new();
        lt_plan *pa, *pb;

        fill(values, 105 * batch, 3);
        check_ok(lt_onnx_import(arena, g, &m, batch, &ports));
        a = run(&pa, ours, y, values);
        b = run(&pb, ports.input[0], ports.output[0], values);
        ck_assert(lt_same_shape(&y->shape, &ports.output[0]->shape));
        for (int64_t i = 0; i < lt_numel(y); i++)
            ck_assert_float_eq(a[i], b[i]);
        lt_plan_free(pa);
        lt_plan_free(pb);
        lt_graph_free(g);
        lt_graph_free(ours->graph);
    }
    lt_arena_free(arena);
}
END_TEST

/* ---- files of others: scripts/vectors/onnx_models.py ------------------------------------------------------------- */

/* bound: of a difference, relative to the largest number or to 1 */
static const struct {
    const char *name;
    double bound;
} others[] = {
    { "torch", 1e-6 }, { "helper", 1e-6 },
    /* torchvision's networks, thin, in PyTorch's words of these operator sets */
    { "resnet-11", 3e-6 }, { "resnet-17", 3e-6 }, { "mobilenet_v2-12", 1e-6 }, { "efficientnet-14", 1e-6 },
    { "mobilenet_v3-13", 1e-6 }, { "mobilenet_v3-16", 1e-6 }, { "vit-11", 1e-6 }, { "vit-13", 1e-6 },
    { "vit-17", 1e-6 },
    /* operators by themselves, held against ONNX Runtime */
    { "operators-11", 1e-6 }, { "operators-12", 1e-6 }, { "operators-13", 1e-6 }, { "operators-14", 1e-6 },
    { "operators-17", 1e-6 }, { "operators-20", 1e-6 },
};

static const lt_array *numbers_of(const lt_npz *npz, const char *name, const lt_tensor *t)
{
    const lt_array *a = lt_npz_find(npz, name);

    ck_assert_msg(a && a->rank == t->shape.rank, "%s", name);
    for (int i = 0; i < a->rank; i++)
        ck_assert_int_eq(a->shape[i], t->shape.dim[i]);
    return a;
}

static void check_output(const lt_real *got, const lt_array *want, const char *name, double bound)
{
    double largest = 1;

    for (size_t i = 0; i < lt_array_count(want); i++)
        largest = fmax(largest, fabs(lt_array_get(want, i)));
    for (size_t i = 0; i < lt_array_count(want); i++)
        ck_assert_msg(fabs((double)got[i] - lt_array_get(want, i)) < bound * largest, "%s[%zu] is %.9g, want %.9g",
                      name, i, (double)got[i], lt_array_get(want, i));
}

START_TEST(other_writers_are_read)
{
    const char *top = getenv("srcdir") ? getenv("srcdir") : "..", *name = others[_i].name;
    lt_arena *arena = lt_arena_new();
    lt_graph *g = lt_graph_new();
    lt_onnx_ports ports;
    lt_onnx_model m;
    lt_npz npz;
    lt_plan *p;

    check_ok(lt_npz_read(arena, lt_arena_printf(arena, "%s/tests/vectors/onnx/%s.npz", top, name), &npz));
    check_ok(lt_onnx_read(arena, lt_arena_printf(arena, "%s/tests/vectors/onnx/%s.onnx", top, name), &m));
    check_ok(lt_onnx_import(arena, g, &m, 2, &ports));
    p = lt_compile(g, NULL);
    ck_assert_msg(p, "%s", lt_last_error());
    for (int i = 0; i < m.n_inputs; i++) {
        const lt_array *x = numbers_of(&npz, m.input[i].name, ports.input[i]);
        lt_real *values = lt_plan_data(p, ports.input[i]);

        for (size_t k = 0; k < lt_array_count(x); k++)
            values[k] = (lt_real)lt_array_get(x, k);
    }
    lt_run(p);
    for (int i = 0; i < m.n_outputs; i++)
        check_output(lt_plan_data(p, ports.output[i]), numbers_of(&npz, m.output[i].name, ports.output[i]),
                     m.output[i].name, others[_i].bound);
    lt_plan_free(p);
    lt_graph_free(g);
    lt_arena_free(arena);
}
END_TEST

/* ---- files of nobody --------------------------------------------------------------------------------------------- */

/* Recorded too: rules are a part of what a stranger's file meets. */
static lt_status read_it(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_onnx_ports ports;
    lt_onnx_model m;
    lt_graph *g = lt_graph_new();
    lt_status st = lt_onnx_parse(arena, "file", bytes, n, &m);

    if (st == LT_OK)
        st = lt_onnx_import(arena, g, &m, 2, &ports);
    lt_graph_free(g);
    return st;
}

START_TEST(damaged)
{
    lt_arena *arena = lt_arena_new();
    size_t n;
    uint8_t *bytes = small_file(arena, &n);

    check_truncated(read_it, bytes, n, 0);
    check_flipped(read_it, bytes, n, 20000);
    lt_arena_free(arena);
}
END_TEST

/* Of every operator there is a rule for: nodes first, so cuts fall among them, and most flips. */
START_TEST(damaged_operators)
{
    const char *top = getenv("srcdir") ? getenv("srcdir") : "..";
    lt_arena *arena = lt_arena_new();
    uint8_t *bytes;
    size_t n;

    for (size_t i = 0; i < LT_COUNT(others); i++) {
        if (strncmp(others[i].name, "operators", 9))
            continue;
        check_ok(lt_read_file(arena, lt_arena_printf(arena, "%s/tests/vectors/onnx/%s.onnx", top, others[i].name),
                              INT32_MAX, &bytes, &n));
        check_flipped(read_it, bytes, n, 3000);
        for (size_t cut = i; cut < n; cut += 97)
            ck_assert_int_ne(attempt(read_it, bytes, cut), LT_OK);
    }
    lt_arena_free(arena);
}
END_TEST

/* A model by hand: one node, one tensor, an input x (2, 3); more is put in by fields */
typedef struct {
    const char *op, *in[3], *attr, *domain;
    int attr_kind;
    int64_t attr_int;
    const int64_t *dims;
    int n_dims;
    int64_t type;
    size_t bytes;                       /* of the tensor's data */
    bool external, twice, functions, sparse, other_opset, no_graph, zero_name, port_of_text;
} forged;

static void put_attr(pb_sink *s, const void *what)
{
    const forged *f = what;

    pb_put_text(s, ATTR_NAME, f->attr);
    pb_put_int(s, ATTR_TYPE, f->attr_kind);
    if (f->attr_kind == LT_ONNX_A_INT)
        pb_put_int(s, ATTR_I, f->attr_int);
    for (int i = 0; f->attr_kind == LT_ONNX_A_INTS && i < 2; i++)
        pb_put_int(s, ATTR_INTS, f->attr_int);
}

static void put_node(pb_sink *s, const void *what)
{
    const forged *f = what;

    for (int i = 0; i < 3 && f->in[i]; i++)
        pb_put_text(s, NODE_INPUT, f->in[i]);
    pb_put_text(s, NODE_OUTPUT, "y");
    pb_put_text(s, NODE_OP, f->op);
    if (f->domain)
        pb_put_text(s, NODE_DOMAIN, f->domain);
    if (f->attr)
        pb_put_message(s, NODE_ATTRIBUTE, put_attr, f);
}

static void put_tensor(pb_sink *s, const void *what)
{
    static const uint8_t zeros[64];
    const forged *f = what;

    for (int i = 0; i < f->n_dims; i++)
        pb_put_int(s, TENSOR_DIMS, f->dims[i]);
    pb_put_int(s, TENSOR_TYPE, f->type);
    if (f->zero_name)
        pb_put_bytes(s, TENSOR_NAME, "k\0k", 3);
    else
        pb_put_text(s, TENSOR_NAME, "k");
    if (f->external)
        pb_put_bytes(s, TENSOR_EXTERNAL, "\n\10location\22\13/etc/passwd", 23);
    pb_put_bytes(s, TENSOR_RAW, zeros, f->bytes);
}

static void put_dim(pb_sink *s, const void *what) { pb_put_int(s, DIM_VALUE, *(const int64_t *)what); }

static void put_shape(pb_sink *s, const void *what)
{
    (void)what;
    pb_put_message(s, SHAPE_DIM, put_dim, &(int64_t){ 2 });
    pb_put_message(s, SHAPE_DIM, put_dim, &(int64_t){ 3 });
}

static void put_tensor_type(pb_sink *s, const void *what)
{
    pb_put_int(s, TENSOR_TYPE_ELEM, ((const forged *)what)->port_of_text ? 8 : 1);
    pb_put_message(s, TENSOR_TYPE_SHAPE, put_shape, what);
}

static void put_type(pb_sink *s, const void *what) { pb_put_message(s, TYPE_TENSOR, put_tensor_type, what); }

static void put_x(pb_sink *s, const void *what)
{
    pb_put_text(s, VALUE_NAME, "x");
    pb_put_message(s, VALUE_TYPE, put_type, what);
}

static void put_y(pb_sink *s, const void *what)
{
    pb_put_text(s, VALUE_NAME, "y");
    pb_put_message(s, VALUE_TYPE, put_type, what);
}

static void put_graph(pb_sink *s, const void *what)
{
    const forged *f = what;

    pb_put_message(s, GRAPH_NODE, put_node, f);
    if (f->twice)
        pb_put_message(s, GRAPH_NODE, put_node, f);
    if (f->type)
        pb_put_message(s, GRAPH_INITIALIZER, put_tensor, f);
    if (f->sparse)
        pb_put_bytes(s, GRAPH_SPARSE_INITIALIZER, "", 0);
    pb_put_message(s, GRAPH_INPUT, put_x, f);
    pb_put_message(s, GRAPH_OUTPUT, put_y, f);
}

static void put_opset(pb_sink *s, const void *what)
{
    pb_put_text(s, OPSET_DOMAIN, "");
    pb_put_int(s, OPSET_VERSION, ((const forged *)what)->other_opset ? 9 : 17);
}

static size_t forge(const forged *f, uint8_t *out, size_t room)
{
    pb_sink s = { fmemopen(out, room, "wb"), 0 };

    pb_put_int(&s, MODEL_IR, 8);
    if (!f->no_graph)
        pb_put_message(&s, MODEL_GRAPH, put_graph, f);
    pb_put_message(&s, MODEL_OPSET, put_opset, f);
    if (f->functions)
        pb_put_bytes(&s, MODEL_FUNCTIONS, "", 0);
    fclose(s.f);
    ck_assert_uint_lt(s.bytes, room);
    return (size_t)s.bytes;
}

#define DIMS(...) .dims = (const int64_t[]){ __VA_ARGS__ }, \
    .n_dims = (int)(sizeof((const int64_t[]){ __VA_ARGS__ }) / sizeof(int64_t))
#define INTS(n, ...) .type = LT_ONNX_INT64, .bytes = 8 * (n), DIMS(__VA_ARGS__)

static const struct {
    forged file;
    const char *reason;                 /* NULL: read */
} forgeries[] = {
    { { .op = "Relu", .in = { "x" } }, NULL },
    { { .op = "Add", .in = { "x", "k" }, .type = 1, .bytes = 12, DIMS(3) }, NULL },
    { { .op = "Add", .in = { "x", "k" }, .type = 1, .bytes = 8, DIMS(3) }, "8 bytes of data, its shape wants 12" },
    { { .op = "Add", .in = { "x", "k" }, .type = 1, .bytes = 12, DIMS(-3) }, "a shape that cannot be" },
    { { .op = "Add", .in = { "x", "k" }, .type = 1, .bytes = 0, DIMS(1ll << 40, 1ll << 40, 0) },
      "a shape that cannot be" },
    { { .op = "Add", .in = { "x", "k" }, .type = 1, .bytes = 4, DIMS(1, 1, 1, 1, 1, 1, 1) }, "more than 6 dimensions" },
    { { .op = "Add", .in = { "x", "k" }, .type = 1, .bytes = 16, DIMS(4) }, "do not broadcast" },
    { { .op = "Add", .in = { "x", "k" }, .type = 11, .bytes = 24, DIMS(3) }, "is of type 11" },
    { { .op = "Add", .in = { "x", "k" }, .type = 1, .bytes = 12, DIMS(3), .external = true }, "is not opened" },
    { { .op = "Add", .in = { "x", "k" }, .type = 1, .bytes = 12, DIMS(3), .zero_name = true }, "a zero byte" },
    { { .op = "Add", .in = { "x", "q" } }, "input \"q\" has not been made before" },
    { { .op = "Add", .in = { "x", "y" } }, "input \"y\" has not been made before" },
    { { .op = "Add", .in = { "x" } }, "1 inputs, want 2 to 2" },
    { { .op = "Add", .in = { "x", "" } }, "input 1 is missing" },
    { { .op = "Relu", .in = { "x" }, .twice = true }, "value \"y\" is made twice" },
    { { .op = "Relu", .in = { "x" }, .functions = true }, "functions of the model's own" },
    { { .op = "Relu", .in = { "x" }, .sparse = true }, "sparse tensors" },
    { { .op = "Relu", .in = { "x" }, .other_opset = true }, "operator set 9; 11 to 20 are read" },
    { { .op = "Relu", .in = { "x" }, .no_graph = true }, "no ONNX model" },
    { { .op = "Relu", .in = { "x" }, .port_of_text = true }, "\"x\" is of type 8" },
    { { .op = "Relu", .in = { "x" }, .domain = "com.microsoft" }, "operator \"Relu\" is of \"com.microsoft\"" },
    { { .op = "Loop", .in = { "x" } }, "this operator is not understood" },
    { { .op = "Loop", .in = { "x" }, .attr = "body", .attr_kind = 5 }, "attribute \"body\" is of kind 5" },
    { { .op = "Relu", .in = { "x" }, .attr = "clip", .attr_kind = 2 }, "attribute \"clip\" is not understood" },
    { { .op = "Softmax", .in = { "x" }, .attr = "axis", .attr_kind = 2, .attr_int = 0 }, NULL },
    { { .op = "Constant", .attr = "value", .attr_kind = 4 }, "attribute \"value\" has no tensor" },
    { { .op = "Constant", .attr = "value_ints", .attr_kind = 7, .attr_int = 3 }, "output \"y\" is no result" },
    { { .op = "Constant", .attr = "value_string", .attr_kind = 3 }, "\"value_string\" is not understood" },
    { { .op = "Constant", .attr = "value_ints", .attr_kind = 2 }, "\"value_ints\" is of kind 2, which holds no value" },
    { { .op = "Constant" }, "0 attributes, want one that holds its value" },
    { { .op = "Expand", .in = { "x", "k" }, INTS(2, 2) }, "(2, 3) and (0, 0) do not broadcast" },
    { { .op = "Softmax", .in = { "x" }, .attr = "axis", .attr_kind = 2, .attr_int = 9 },
      "\"axis\" is 9, want -2 to 1" },
    { { .op = "Softmax", .in = { "x" }, .attr = "axis", .attr_kind = 7, .attr_int = 1 }, "is of kind 7, want 2" },
    { { .op = "Transpose", .in = { "x" }, .attr = "perm", .attr_kind = 7, .attr_int = 1 }, "is no permutation" },
    { { .op = "Transpose", .in = { "x" }, .attr = "perm", .attr_kind = 7, .attr_int = -1 }, "is no permutation" },
    { { .op = "MaxPool", .in = { "x" }, .attr = "kernel_shape", .attr_kind = 7, .attr_int = -1 }, "want 1 to" },
    { { .op = "MaxPool", .in = { "x" }, .attr = "kernel_shape", .attr_kind = 7, .attr_int = 2 }, "want 4 dimensions" },
    { { .op = "MaxPool", .in = { "x" }, .attr = "strides", .attr_kind = 7, .attr_int = 0 }, "\"kernel_shape\" is 0" },
    { { .op = "Reshape", .in = { "x", "k" }, INTS(1, 1) }, "the new shape has 2 elements, want 6" },
    { { .op = "Reshape", .in = { "x", "x" } }, "is not known before the model runs" },
    { { .op = "Reshape", .in = { "x", "k" }, INTS(7, 7) }, "7 dimensions" },
    { { .op = "Gather", .in = { "x", "k" }, INTS(2, 2) }, NULL },
    { { .op = "Gather", .in = { "x", "k" }, INTS(4, 2, 2) }, NULL },
    { { .op = "Slice", .in = { "x", "k", "k" }, INTS(2, 2) }, NULL },
    { { .op = "Slice", .in = { "x", "k", "k" }, INTS(7, 7) }, "7 starts" },
    { { .op = "Concat", .in = { "x", "k" }, INTS(1, 1) }, "holds whole numbers" },
    { { .op = "MatMul", .in = { "x", "x" } }, "linear" },
    { { .op = "Conv", .in = { "x", "x" } }, "want 4 dimensions" },
    { { .op = "Cast", .in = { "x" }, .attr = "to", .attr_kind = 2, .attr_int = 10 }, "to type 10" },
    { { .op = "Identity", .in = { "k" }, INTS(1, 1) }, "output \"y\" is no result of the graph" },
    { { .op = "Range", .in = { "x", "x", "x" } }, "is not known before" },
    { { .op = "Flatten", .in = { "x" } }, NULL },
    { { .op = "", .in = { "x" } }, "a node without an operator" },
};

START_TEST(forged_files)
{
    uint8_t bytes[1024];
    const size_t n = forge(&forgeries[_i].file, bytes, sizeof(bytes));

    if (forgeries[_i].reason)
        check_refused(read_it, bytes, n, forgeries[_i].reason);
    else
        check_ok(attempt(read_it, bytes, n));
}
END_TEST

/* A list of empty messages asks for a struct each: memory stays within what the file's size allows. */
START_TEST(small_file_small_memory)
{
    enum { PAIRS = 100000 };
    lt_arena *arena = lt_arena_new();
    uint8_t *bytes = malloc(2 * PAIRS + 16);
    lt_onnx_model m;
    pb_sink s = { fmemopen(bytes, 16, "wb"), 0 };
    size_t n;

    pb_put_bytes(&s, MODEL_GRAPH, "", 0);
    fclose(s.f);
    n = s.bytes - 1;                            /* the length of the graph, again */
    for (size_t left = 2 * PAIRS; ; left >>= 7) {
        bytes[n++] = (uint8_t)(left & 0x7f) | (left > 0x7f ? 0x80 : 0);
        if (left <= 0x7f)
            break;
    }
    for (int i = 0; i < PAIRS; i++) {
        bytes[n++] = GRAPH_INITIALIZER << 3 | PB_BYTES;
        bytes[n++] = 0;
    }
    check_error(lt_onnx_parse(arena, "file", bytes, n, &m), LT_EFORMAT, "");
    ck_assert_uint_lt(lt_arena_bytes(arena), 16 * n + (1 << 20));
    free(bytes);
    lt_arena_free(arena);
}
END_TEST

START_TEST(bad_wire)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *reason;
    } cases[] = {
        { "", 0, "no ONNX model" },
        { "\x80", 1, "offset 0: a field's number that does not end" },
        { "\x00", 1, "a field's number that cannot be" },
        { "\x0b", 1, "a field of a kind that is not read" },
        { "\x08\x80\x80\x80\x80\x80\x80\x80\x80\x80\x80\x01", 12, "a number that does not end" },
        { "\x3a\x05\x00", 3, "a length that passes the end" },
        { "\x3a\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01", 11, "a length that passes the end" },
        { "\x09\x00", 2, "a number is cut off" },
        { "\x38\x00", 2, "field 7 is of kind 0, want 2" },
        { "PK\3\4", 4, "a zip archive, want an ONNX file" },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++)
        check_refused(read_it, cases[i].bytes, cases[i].n, cases[i].reason);
}
END_TEST

START_TEST(no_file)
{
    lt_arena *arena = lt_arena_new();
    lt_onnx_model m;

    check_error(lt_onnx_read(arena, in_folder("none.onnx"), &m), LT_EIO, "none.onnx");
    lt_arena_free(arena);
}
END_TEST

/* Fail the 1st, 2nd, 3rd ... allocation until reading succeeds. */
START_TEST(without_memory)
{
    lt_arena *arena = lt_arena_new();
    lt_status st = LT_ENOMEM;
    size_t n;
    uint8_t *bytes = small_file(arena, &n);

    for (long at = 1; st; at++) {
        lt_arena *mine = lt_arena_new();
        lt_graph *g = lt_graph_new();
        lt_onnx_ports ports;
        lt_onnx_model m;

        lt_alloc_fail_at(at);
        st = lt_onnx_parse(mine, "small", bytes, n, &m);
        if (st == LT_OK)
            st = lt_onnx_import(mine, g, &m, 1, &ports);
        lt_alloc_fail_at(0);
        ck_assert_msg(st == LT_OK || st == LT_ENOMEM, "allocation %ld: %s", at, lt_last_error());
        lt_graph_free(g);
        lt_arena_free(mine);
        ck_assert_int_lt(at, 1000);
    }
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, what_is_written_is_read);
    tcase_add_loop_test(tc, two_ports_of_one_name, 0, 2);
    tcase_add_test(tc, a_file_runs_for_any_batch);
    tcase_add_loop_test(tc, other_writers_are_read, 0, LT_COUNT(others));
    tcase_add_test(tc, damaged);
    tcase_add_test(tc, damaged_operators);
    tcase_add_loop_test(tc, forged_files, 0, LT_COUNT(forgeries));
    tcase_add_test(tc, small_file_small_memory);
    tcase_add_test(tc, bad_wire);
    tcase_add_test(tc, no_file);
    tcase_add_test(tc, without_memory);
}

int main(void)
{
    return run_suite("onnx", add_tests);
}
