/* SPDX-License-Identifier: Apache-2.0 */
/* ONNX messages field by field: what each may hold, in which way, and what is said of the rest. Messages are written
 * as text, by the numbers of onnx.proto: 7{...} a message, 2"y" text, 1=3 a number, 7[1 2] packed ones, 9:12 so many
 * zero bytes. */
#include "libtensor/io/onnx/onnx.h"
#include "libtensor/io/protobuf.h"
#include "tests/io/hostile.h"

#include <ctype.h>

/* ---- text to bytes --------------------------------------------------------------------------------------------- */

static const char *put_fields(pb_sink *s, const char *at);

static void put_fields_of(pb_sink *s, const void *at) { put_fields(s, at); }

/* What is behind '{', up to and with its '}' */
static const char *put_inner(pb_sink *s, int field, const char *at)
{
    pb_sink nowhere = { 0 };

    pb_put_message(s, field, put_fields_of, at);
    return put_fields(&nowhere, at) + 1;
}

static const char *put_packed(pb_sink *s, int field, const char *at)
{
    uint8_t bytes[64];
    size_t n = 0;

    while (*at != ']') {
        char *end;

        for (uint64_t x = strtoull(at, &end, 10); ; x >>= 7) {
            bytes[n++] = (uint8_t)((x & 0x7f) | (x > 0x7f ? 0x80 : 0));
            if (x <= 0x7f)
                break;
        }
        at = end;
    }
    pb_put_bytes(s, field, bytes, n);
    return at + 1;
}

static const char *put_fields(pb_sink *s, const char *at)
{
    static const uint8_t zeros[64];
    char *end;

    while (isdigit(*at)) {
        const int field = (int)strtol(at, &end, 10);

        at = end + 1;
        if (*end == '{') {
            at = put_inner(s, field, at);
        } else if (*end == '"') {
            pb_put_bytes(s, field, at, strcspn(at, "\""));
            at += strcspn(at, "\"") + 1;
        } else if (*end == '[') {
            at = put_packed(s, field, at);
        } else if (*end == ':') {
            pb_put_bytes(s, field, zeros, (size_t)strtol(at, (char **)&at, 10));
        } else {
            pb_put_int(s, field, strtoll(at, (char **)&at, 10));
        }
        at += strspn(at, " ");
    }
    return at;
}

static size_t bytes_of(const char *text, uint8_t *out, size_t room)
{
    pb_sink s = { fmemopen(out, room, "wb"), 0 };

    ck_assert_int_eq(*put_fields(&s, text), '\0');
    fclose(s.f);
    ck_assert_uint_lt(s.bytes, room);
    return (size_t)s.bytes;
}

/* ---- models ---------------------------------------------------------------------------------------------------- */

#define TWO_BY_THREE "1{1=2}1{1=3}"
#define PORT(name, type, shape) "1\"" name "\"2{1{1=" type " 2{" shape "}}}"
#define X "11{" PORT("x", "1", TWO_BY_THREE) "}"
#define Y "12{" PORT("y", "1", TWO_BY_THREE) "}"
#define SET "8{2=17}"
#define GRAPH(fields) "7{" fields " " X Y "}" SET
#define NODE(op, fields) "1{1\"x\"2\"y\"4\"" op "\"" fields "}"
#define K(op, fields) GRAPH("1{1\"x\"1\"k\"2\"y\"4\"" op "\"}5{8\"k\"" fields "}")
#define INPUT(fields) "7{" NODE("Relu", "") "11{" fields "}" Y "}" SET
#define ATTR(op, fields) GRAPH(NODE(op, "5{" fields "}"))

static const struct {
    const char *text, *reason;          /* NULL: read */
} cases[] = {
    { GRAPH(NODE("Relu", "")), NULL },
    { GRAPH(NODE("Relu", "")) "1=8 40=1 2\"producer\"", NULL },
    { GRAPH(NODE("Relu", "7\"ai.onnx\"") "10\"what it is for\""), NULL },
    { GRAPH(NODE("Relu", "")) "8{1\"com.example\"2=1}", NULL },
    /* numbers of a tensor */
    { K("Reshape", "1=2 2=7 7[3 2]"), NULL },
    { K("Reshape", "1=2 2=6 5[3 2]"), NULL },
    { K("Reshape", "1[2] 2=7 9:16 14=0"), NULL },
    { K("Add", "1=3 2=1 4:12"), NULL },
    { K("Add", "1=2 1=0 2=1"), "do not broadcast" },
    { K("Reshape", "1=3 2=7 7[1 2]"), "tensor \"k\" has less data than its shape wants" },
    { K("Reshape", "1=2 2=7 7[300]"), "tensor \"k\" has less data than its shape wants" },
    { K("Reshape", "1=1 2=7 7[1 2]"), "tensor \"k\" has more data than its shape wants" },
    { K("Reshape", "1=1 2=7 7[1] 9:8"), "tensor \"k\" has its data in several pieces" },
    { K("Add", "1=3 2=1 7[1 2 3]"), "tensor \"k\" has data of another type" },
    { K("Reshape", "1=1 2=7 4:8"), "tensor \"k\" has data of another type" },
    { K("Add", "1=3 2=1 9:12 14=1"), "kept in another file, which is not opened; save the model as one file" },
    { K("Add", "1=2147483648 1=2147483648 2=1 9:12"), "a shape that cannot be" },
    { K("Add", "1=3 2=1 9=1"), "field 9 is of kind 0, want 2" },
    { K("Add", "1=3 2=1 4=1"), "field 4 is of kind 0, want 2" },
    { K("Add", "1\"\x80\" 2=1 9:12"), "a packed list that does not end" },
    { GRAPH(NODE("Relu", "") "5=1"), "field 5 is of kind 0, want 2" },
    /* attributes */
    { ATTR("Flatten", "1\"axis\"20=2 3=1"), NULL },
    { ATTR("Transpose", "1\"perm\"20=7 8[0 1]"), NULL },
    { ATTR("Transpose", "1\"perm\"20=7 8=0 8=1"), NULL },
    { ATTR("Transpose", "1\"perm\"20=7 8\"\x80\""), "a packed list that does not end" },
    { ATTR("LeakyRelu", "1\"alpha\"20=1 2=1"), "field 2 is of kind 0, want 5" },
    { GRAPH("1{2\"k\"4\"Constant\"5{1\"value_floats\"20=6 7:12}}1{1\"x\"1\"k\"2\"y\"4\"Add\"}"), NULL },
    { GRAPH("1{2\"k\"4\"Constant\"5{1\"value_floats\"20=6 7:13}}1{1\"x\"1\"k\"2\"y\"4\"Add\"}"),
      "a packed list that does not end" },
    { GRAPH("1{2\"k\"4\"Constant\"5{1\"value_floats\"20=6 7=3}}"), "field 7 is of kind 0, want 2" },
    { GRAPH("1{2\"k\"4\"Constant\"5{1\"value\"20=4 5{1=3 2=1 9:12}}}1{1\"x\"1\"k\"2\"y\"4\"Add\"}"), NULL },
    { GRAPH("1{2\"k\"4\"Constant\"5{1\"value\"20=4 5{2=1 9:4}5{2=1 9:4}}}"), "an attribute of several tensors" },
    { GRAPH("1{2\"k\"4\"Constant\"5{1\"value\"20=4 5{1=3 2=1 9:11}}}"), "has 11 bytes of data, its shape wants 12" },
    { GRAPH("1{2\"k\"4\"Constant\"5{1\"value\"20=4 5{1=3 2=9 9:3}}}1{1\"k\"1\"x\"1\"x\"2\"y\"4\"Where\"}"), NULL },
    { GRAPH("1{1\"k\"1\"x\"1\"x\"2\"y\"4\"Where\"}5{8\"k\"1=3 2=9 5[0 1 1]}"), NULL },
    { ATTR("Flatten", "1\"axis\"20\"x\""), "field 20 is of kind 2, want 0" },
    { ATTR("Flatten", "1=1"), "field 1 is of kind 0, want 2" },
    { GRAPH(NODE("Flatten", "5=1")), "field 5 is of kind 0, want 2" },
    /* nodes */
    { GRAPH("1=1"), "field 1 is of kind 0, want 2" },
    { GRAPH("1{1=1}"), "field 1 is of kind 0, want 2" },
    { GRAPH("1{1\"x\"4\"Relu\"}"), "a node without an operator or without a result" },
    /* inputs and outputs */
    { INPUT(PORT("x", "1", "1{2\"batch\"}1{1=3}")), NULL },
    { INPUT(PORT("x", "6", TWO_BY_THREE)), "input 0 holds whole numbers, want real ones" },
    { INPUT(PORT("x", "1", "1{1=-5}")), "a dimension below 0" },
    { INPUT(PORT("x", "1", "1{}1{}1{}1{}1{}1{}1{}")), "more than 6 dimensions" },
    { INPUT(PORT("x", "1", "1=2")), "field 1 is of kind 0, want 2" },
    { INPUT(PORT("x", "1", "1{1\"2\"}")), "field 1 is of kind 2, want 0" },
    { INPUT(PORT("", "1", TWO_BY_THREE)), "an input or output without a name or a type" },
    { INPUT("1\"x\""), "an input or output without a name or a type" },
    { INPUT("1\"x\"2=1"), "field 2 is of kind 0, want 2" },
    { INPUT("1\"x\"2{1=1}"), "field 1 is of kind 0, want 2" },
    { INPUT("1\"x\"2{4{}}"), "\"x\" is of type 0; 1 (FLOAT) and 6 (INT32) are read" },
    { INPUT("1\"x\"2{1{1\"f\"}}"), "field 1 is of kind 2, want 0" },
    { INPUT("1\"x\"2{1{1=1 2=1}}"), "field 2 is of kind 0, want 2" },
    { "7{" NODE("Relu", "") X "12=1}" SET, "field 12 is of kind 0, want 2" },
    /* the whole */
    { GRAPH(NODE("Relu", "")) GRAPH(NODE("Relu", "")), "a second graph" },
    { "7=1 8{2=17}", "field 7 is of kind 0, want 2" },
    { "7{2=1}" SET, "field 2 is of kind 0, want 2" },
    { GRAPH(NODE("Relu", "")) "8=1", "field 8 is of kind 0, want 2" },
    { GRAPH(NODE("Relu", "")) "8{1=1}", "field 1 is of kind 0, want 2" },
    { GRAPH(NODE("Relu", "")) "8{2\"1\"}", "field 2 is of kind 2, want 0" },
    { GRAPH(NODE("Relu", "")) "8{2=21}", "operator set 21; 11 to 20 are read" },
    { "7{" NODE("Relu", "") X Y "}8{1\"com.example\"2=1}", "no ONNX model: has no graph, or says no operator set" },
    { GRAPH(NODE("Relu", "")) "14=1", "field 14 is of kind 0, want 2" },
    { GRAPH(NODE("Relu", "")) "14{1=1}", "field 1 is of kind 0, want 2" },
    { GRAPH(NODE("Relu", "")) "14{2=1}", "field 2 is of kind 0, want 2" },
};

/* Recorded too */
static lt_status read_it(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_graph *g = lt_graph_new();
    lt_onnx_ports ports;
    lt_onnx_model m;
    lt_status st = g ? lt_onnx_parse(arena, "file", bytes, n, &m) : LT_ENOMEM;

    if (st == LT_OK)
        st = lt_onnx_import(arena, g, &m, 2, &ports);
    lt_graph_free(g);
    return st;
}

START_TEST(fields)
{
    uint8_t bytes[512];
    const size_t n = bytes_of(cases[_i].text, bytes, sizeof(bytes));

    if (cases[_i].reason) {
        check_refused(read_it, bytes, n, cases[_i].reason);
        return;
    }
    ck_assert_msg(attempt(read_it, bytes, n) == LT_OK, "%s: %s", cases[_i].text, lt_last_error());
    ck_assert_int_gt(check_without_memory(read_it, bytes, n), 0);
}
END_TEST

START_TEST(what_a_file_says_of_itself)
{
    static const char text[] = GRAPH(NODE("Relu", "3\"n\"") "2\"graph\"")
                               "2\"writer\"3\"1.2\"14{1\"k\"2\"v\"}14{1\"only\"}";
    uint8_t bytes[512];
    const size_t n = bytes_of(text, bytes, sizeof(bytes));
    lt_arena *arena = lt_arena_new();
    lt_onnx_model m;

    check_ok(lt_onnx_parse(arena, "file", bytes, n, &m));
    ck_assert_str_eq(m.producer, "writer");
    ck_assert_str_eq(m.version, "1.2");
    ck_assert_str_eq(m.name, "graph");
    ck_assert_str_eq(m.node[0].name, "n");
    ck_assert_int_eq(m.n_meta, 2);
    ck_assert(strcmp(m.meta[0].key, "k") == 0 && strcmp(m.meta[0].value, "v") == 0);
    ck_assert(strcmp(m.meta[1].key, "only") == 0 && strcmp(m.meta[1].value, "") == 0);
    ck_assert_int_eq(m.opset, 17);
    check_error(lt_onnx_parse(arena, "file", bytes, (size_t)INT32_MAX + 1, &m), LT_EFORMAT,
                "2147483648 bytes, but an ONNX file holds at most 2147483647");
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_loop_test(tc, fields, 0, LT_COUNT(cases));
    tcase_add_test(tc, what_a_file_says_of_itself);
}

int main(void)
{
    return run_suite("onnx_wire", add_tests);
}
