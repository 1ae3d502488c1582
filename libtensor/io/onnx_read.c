/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Bytes of a stranger as a model: one function for each message of onnx.proto. Lists are counted before they
 * are allocated, all memory comes from a budget that the file's size sets, and nesting is as deep as these
 * functions call each other.
 */
#include "libtensor/io/onnx.h"

#include "libtensor/io/file.h"
#include "libtensor/io/onnx_fields.h"
#include "libtensor/io/protobuf.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { FIRST_OPSET = 13, LAST_OPSET = 20, BLOCK = 1 << 14 };

typedef struct {
    lt_arena *arena;
    const char *name;
    const uint8_t *bytes;
    size_t budget;                      /* bytes that may still be asked for */
    char *block;
    size_t left;                        /* of block */
    bool has_graph;
} reader;

static lt_status LT_PRINTF(3, 4) bad(const reader *r, const uint8_t *at, const char *fmt, ...)
{
    char why[256];
    va_list args;

    va_start(args, fmt);
    vsnprintf(why, sizeof(why), fmt, args);
    va_end(args);
    return lt_error(LT_EFORMAT, "%s: offset %zu: %s", r->name, (size_t)(at - r->bytes), why);
}

/* ---- memory and fields ---------------------------------------------------------------------------------------- */

/* Small pieces share blocks: an arena's own pieces are a cache line at least. */
static lt_status take(reader *r, const uint8_t *at, size_t count, size_t size, void *out)
{
    size_t n;

    if (!lt_size_mul(count, size, &n) || n > r->budget)
        return bad(r, at, "asks for more memory than such a file may");
    n = n ? (n + 7) / 8 * 8 : 8;
    if (n > r->left) {
        const size_t block = n > BLOCK ? n : BLOCK;

        r->block = lt_arena_alloc(r->arena, block);
        if (!r->block)
            return lt_error(LT_ENOMEM, "%s: no memory for %zu bytes", r->name, block);
        r->left = block;
    }
    r->budget -= n < r->budget ? n : r->budget;
    *(void **)out = r->block;
    r->block += n;
    r->left -= n;
    return LT_OK;
}

static lt_status next(const reader *r, pb_span *m, pb_field *f)
{
    const char *wrong = pb_next(m, f);

    return wrong ? bad(r, f->at, "%s", wrong) : LT_OK;
}

/* next, and the field is of the kind that its number stands for */
static lt_status want(const reader *r, const pb_field *f, pb_wire wire)
{
    return f->wire == wire ? LT_OK : bad(r, f->at, "field %d is of kind %d, want %d", f->number, f->wire, wire);
}

static lt_status take_text(reader *r, const pb_field *f, const char **out)
{
    const size_t n = pb_size(f->body);
    char *text;
    lt_status st = want(r, f, PB_BYTES);

    if (st == LT_OK && memchr(f->body.at, 0, n))
        st = bad(r, f->at, "a name with a zero byte");
    if (st == LT_OK)
        st = take(r, f->at, n + 1, 1, &text);
    if (st)
        return st;
    memcpy(text, f->body.at, n);
    text[n] = '\0';
    *out = text;
    return LT_OK;
}

static lt_status take_int(const reader *r, const pb_field *f, int64_t *out)
{
    const lt_status st = want(r, f, PB_VARINT);

    *out = (int64_t)f->value;
    return st;
}

/* How many fields of each number below 32 a message has */
static lt_status count_fields(const reader *r, pb_span m, int n[32])
{
    memset(n, 0, 32 * sizeof(*n));
    while (m.at < m.end) {
        pb_field f;
        const lt_status st = next(r, &m, &f);

        if (st)
            return st;
        if (f.number < 32)
            n[f.number]++;
    }
    return LT_OK;
}

/* A list of whole numbers: one a field, or packed */
static lt_status add_ints(const reader *r, const pb_field *f, int64_t *list, int room, int *n)
{
    pb_span packed = f->body;
    uint64_t x;

    if (f->wire == PB_VARINT) {
        if (*n < room)
            list[(*n)++] = (int64_t)f->value;
        return LT_OK;
    }
    for (; f->wire == PB_BYTES && packed.at < packed.end && *n < room; list[(*n)++] = (int64_t)x)
        if (!pb_varint(&packed, &x))
            return bad(r, f->at, "a packed list that does not end");
    return want(r, f, PB_BYTES);
}

/* ---- tensors ----------------------------------------------------------------------------------------------------- */

/* The elements, as they came */
typedef struct {
    const uint8_t *at;
    pb_field raw, packed;
    int n_raw, n_packed;
    int64_t type;
    int64_t dim[LT_MAX_RANK + 1];
    int rank;
} tensor_parts;

static lt_status tensor_field(reader *r, const pb_field *f, tensor_parts *p, lt_onnx_tensor *t)
{
    switch (f->number) {
    case TENSOR_DIMS: return add_ints(r, f, p->dim, LT_MAX_RANK + 1, &p->rank);
    case TENSOR_TYPE: return take_int(r, f, &p->type);
    case TENSOR_NAME: return take_text(r, f, &t->name);
    case TENSOR_RAW:
        p->raw = *f;
        p->n_raw++;
        return want(r, f, PB_BYTES);
    case TENSOR_FLOATS: case TENSOR_INT32S: case TENSOR_INT64S:
        p->packed = *f;
        p->n_packed++;
        return want(r, f, PB_BYTES);
    case TENSOR_EXTERNAL:
        return bad(r, f->at, "numbers are kept in another file, which is not opened; save the model as one file");
    case TENSOR_LOCATION:
        return f->value == 0 ? LT_OK : bad(r, f->at, "numbers are kept in another file, which is not opened; save the "
                                                     "model as one file");
    default: return LT_OK;
    }
}

static lt_status check_shape(const reader *r, const tensor_parts *p, lt_shape *shape, size_t *numel)
{
    if (p->rank > LT_MAX_RANK)
        return bad(r, p->at, "more than %d dimensions", LT_MAX_RANK);
    shape->rank = p->rank;
    *numel = 1;
    for (int i = 0; i < p->rank; i++) {
        shape->dim[i] = p->dim[i];
        if (p->dim[i] < 0 || !lt_size_mul(*numel, (size_t)p->dim[i], numel) || *numel > INT64_MAX / 8)
            return bad(r, p->at, "a shape that cannot be");
    }
    return LT_OK;
}

/* Packed whole numbers are varints; they become the array that raw ones are. */
static lt_status unpack(reader *r, const tensor_parts *p, size_t numel, lt_onnx_tensor *t)
{
    pb_span list = p->packed.body;
    char *data;
    lt_status st;

    if (numel > pb_size(list))
        return bad(r, p->at, "tensor \"%s\" has less data than its shape wants", t->name);
    st = take(r, p->at, numel, t->type == LT_ONNX_INT64 ? 8 : 4, &data);
    if (st)
        return st;
    for (size_t i = 0; i < numel; i++) {
        uint64_t x;

        if (!pb_varint(&list, &x))
            return bad(r, p->at, "tensor \"%s\" has less data than its shape wants", t->name);
        if (t->type == LT_ONNX_INT64)
            memcpy(data + 8 * i, &x, 8);
        else
            memcpy(data + 4 * i, &(int32_t){ (int32_t)x }, 4);
    }
    t->data = data;
    return list.at == list.end ? LT_OK : bad(r, p->at, "tensor \"%s\" has more data than its shape wants", t->name);
}

static lt_status take_data(reader *r, const tensor_parts *p, size_t numel, lt_onnx_tensor *t)
{
    static const uint8_t nothing[1];
    const pb_field *f = p->n_raw ? &p->raw : &p->packed;
    const size_t width = t->type == LT_ONNX_INT64 ? 8 : 4;

    if (p->n_raw + p->n_packed > 1)
        return bad(r, p->at, "tensor \"%s\" has its data in several pieces", t->name);
    if (p->n_packed && p->packed.number != TENSOR_FLOATS && t->type != LT_ONNX_FLOAT)
        return unpack(r, p, numel, t);
    if (p->n_packed && (p->packed.number == TENSOR_FLOATS) != (t->type == LT_ONNX_FLOAT))
        return bad(r, p->at, "tensor \"%s\" has data of another type", t->name);
    if (numel * width != pb_size(f->body))
        return bad(r, p->at, "tensor \"%s\" has %zu bytes of data, its shape wants %zu", t->name, pb_size(f->body),
                   numel * width);
    t->data = f->body.at ? f->body.at : nothing;
    return LT_OK;
}

static lt_status take_tensor(reader *r, const pb_field *field, lt_onnx_tensor *t)
{
    tensor_parts p = { .at = field->at };
    pb_span m = field->body;
    lt_status st = want(r, field, PB_BYTES);
    size_t numel = 0;

    t->name = "";
    while (st == LT_OK && m.at < m.end) {
        pb_field f;

        st = next(r, &m, &f);
        if (st == LT_OK)
            st = tensor_field(r, &f, &p, t);
    }
    if (st == LT_OK && p.type != LT_ONNX_FLOAT && p.type != LT_ONNX_INT32 && p.type != LT_ONNX_INT64)
        st = bad(r, p.at, "tensor \"%s\" is of type %jd; 1 (FLOAT), 6 (INT32), 7 (INT64) are read", t->name,
                 (intmax_t)p.type);
    if (st == LT_OK)
        st = check_shape(r, &p, &t->shape, &numel);
    if (st)
        return st;
    t->type = (lt_onnx_type)p.type;
    return take_data(r, &p, numel, t);
}

/* ---- nodes ---------------------------------------------------------------------------------------------------------- */

/* Whole numbers may be packed: as many as they have bytes at most. */
static lt_status make_int_list(reader *r, pb_span m, lt_onnx_attr *a, size_t *room)
{
    void *list;
    lt_status st = LT_OK;

    *room = 0;
    while (st == LT_OK && m.at < m.end) {
        pb_field f;

        st = next(r, &m, &f);
        if (st == LT_OK && f.number == ATTR_INTS)
            *room += f.wire == PB_VARINT ? 1 : pb_size(f.body);
    }
    if (st == LT_OK)
        st = take(r, m.at, *room, sizeof(int64_t), &list);
    if (st == LT_OK)
        a->ints = list;
    return st;
}

static lt_status attr_field(reader *r, const pb_field *f, size_t room, lt_onnx_attr *a)
{
    const uint32_t bits = (uint32_t)f->value;
    int64_t kind;
    lt_status st;

    switch (f->number) {
    case ATTR_NAME: return take_text(r, f, &a->name);
    case ATTR_S: return take_text(r, f, &a->text);
    case ATTR_I: return take_int(r, f, &a->i);
    case ATTR_INTS: return add_ints(r, f, (int64_t *)a->ints, (int)room, &a->n_ints);
    case ATTR_F:
        memcpy(&a->f, &bits, sizeof(bits));
        return want(r, f, PB_FIXED32);
    case ATTR_TYPE:
        st = take_int(r, f, &kind);
        a->kind = (lt_onnx_attr_kind)kind;
        return st;
    default: return LT_OK;
    }
}

static bool is_read(lt_onnx_attr_kind kind)
{
    return kind == LT_ONNX_A_FLOAT || kind == LT_ONNX_A_INT || kind == LT_ONNX_A_TEXT || kind == LT_ONNX_A_INTS;
}

static lt_status take_attr(reader *r, const pb_field *field, lt_onnx_attr *a)
{
    pb_span m = field->body;
    size_t room = 0;
    lt_status st = want(r, field, PB_BYTES);

    a->name = a->text = "";
    if (st == LT_OK)
        st = make_int_list(r, m, a, &room);
    if (st == LT_OK && room > INT32_MAX)
        st = bad(r, field->at, "a list of more than 2^31 numbers");
    while (st == LT_OK && m.at < m.end) {
        pb_field f;

        st = next(r, &m, &f);
        if (st == LT_OK)
            st = attr_field(r, &f, room, a);
    }
    if (st == LT_OK && !is_read(a->kind))
        st = bad(r, field->at, "attribute \"%s\" is of kind %d; a number, numbers or a text are read, no tensors or "
                 "graphs", a->name, (int)a->kind);
    return st;
}

static lt_status node_field(reader *r, const pb_field *f, lt_onnx_node *n, const char **domain)
{
    switch (f->number) {
    case NODE_INPUT: return take_text(r, f, &n->in[n->n_in++]);
    case NODE_OUTPUT: return take_text(r, f, &n->out[n->n_out++]);
    case NODE_NAME: return take_text(r, f, &n->name);
    case NODE_OP: return take_text(r, f, &n->op);
    case NODE_ATTRIBUTE: return take_attr(r, f, &n->attr[n->n_attr++]);
    case NODE_DOMAIN: return take_text(r, f, domain);
    default: return LT_OK;
    }
}

static bool is_standard(const char *domain)
{
    return !*domain || strcmp(domain, "ai.onnx") == 0;
}

static lt_status take_node(reader *r, const pb_field *field, lt_onnx_node *n)
{
    pb_span m = field->body;
    const char *domain = "";
    int count[32];
    lt_status st = want(r, field, PB_BYTES);

    n->op = n->name = "";
    if (st == LT_OK)
        st = count_fields(r, m, count);
    if (st == LT_OK)
        st = take(r, field->at, (size_t)count[NODE_INPUT], sizeof(*n->in), &n->in);
    if (st == LT_OK)
        st = take(r, field->at, (size_t)count[NODE_OUTPUT], sizeof(*n->out), &n->out);
    if (st == LT_OK)
        st = take(r, field->at, (size_t)count[NODE_ATTRIBUTE], sizeof(*n->attr), &n->attr);
    while (st == LT_OK && m.at < m.end) {
        pb_field f;

        st = next(r, &m, &f);
        if (st == LT_OK)
            st = node_field(r, &f, n, &domain);
    }
    if (st == LT_OK && !is_standard(domain))
        st = bad(r, field->at, "operator \"%s\" is of \"%s\"; standard ones are read", n->op, domain);
    if (st == LT_OK && (!*n->op || n->n_out == 0))
        st = bad(r, field->at, "a node without an operator or without a result");
    return st;
}

/* ---- inputs and outputs --------------------------------------------------------------------------------------------- */

/* The field of a message that holds the next message; nothing when it is missing */
static lt_status enter(const reader *r, pb_span *m, int number)
{
    pb_span found = { m->end, m->end };
    lt_status st = LT_OK;

    while (st == LT_OK && m->at < m->end) {
        pb_field f;

        st = next(r, m, &f);
        if (st == LT_OK && f.number == number) {
            st = want(r, &f, PB_BYTES);
            found = f.body;
        }
    }
    *m = found;
    return st;
}

/* A size, or -1 where it has a name or is not known */
static lt_status take_dim(const reader *r, pb_span m, int64_t *dim)
{
    lt_status st = LT_OK;

    *dim = -1;
    while (st == LT_OK && m.at < m.end) {
        pb_field f;

        st = next(r, &m, &f);
        if (st == LT_OK && f.number == DIM_VALUE)
            st = take_int(r, &f, dim);
        if (st == LT_OK && *dim < -1)
            st = bad(r, f.at, "a dimension below 0");
    }
    return st;
}

static lt_status take_dims(const reader *r, pb_span m, lt_shape *shape)
{
    lt_status st = LT_OK;

    while (st == LT_OK && m.at < m.end) {
        pb_field f;

        st = next(r, &m, &f);
        if (st || f.number != SHAPE_DIM)
            continue;
        st = want(r, &f, PB_BYTES);
        if (st == LT_OK && shape->rank == LT_MAX_RANK)
            st = bad(r, f.at, "more than %d dimensions", LT_MAX_RANK);
        if (st == LT_OK)
            st = take_dim(r, f.body, &shape->dim[shape->rank++]);
    }
    return st;
}

static lt_status take_tensor_type(const reader *r, pb_span m, lt_onnx_port *p)
{
    int64_t type = 0;
    const uint8_t *at = m.at;
    lt_status st = LT_OK;

    while (st == LT_OK && m.at < m.end) {
        pb_field f;

        st = next(r, &m, &f);
        if (st == LT_OK && f.number == TENSOR_TYPE_ELEM)
            st = take_int(r, &f, &type);
        if (st == LT_OK && f.number == TENSOR_TYPE_SHAPE)
            st = want(r, &f, PB_BYTES) ? LT_EFORMAT : take_dims(r, f.body, &p->shape);
    }
    if (st == LT_OK && type != LT_ONNX_FLOAT && type != LT_ONNX_INT32)
        st = bad(r, at, "\"%s\" is of type %jd; 1 (FLOAT) and 6 (INT32) are read", p->name, (intmax_t)type);
    p->type = (lt_onnx_type)type;
    return st;
}

static lt_status take_port(reader *r, const pb_field *field, lt_onnx_port *p)
{
    pb_span m = field->body, type = { NULL, NULL };
    lt_status st = want(r, field, PB_BYTES);

    p->name = "";
    while (st == LT_OK && m.at < m.end) {
        pb_field f;

        st = next(r, &m, &f);
        if (st == LT_OK && f.number == VALUE_NAME)
            st = take_text(r, &f, &p->name);
        if (st == LT_OK && f.number == VALUE_TYPE) {
            st = want(r, &f, PB_BYTES);
            type = f.body;
        }
    }
    if (st == LT_OK && (!*p->name || !type.at))
        st = bad(r, field->at, "an input or output without a name or a type");
    if (st == LT_OK)
        st = enter(r, &type, TYPE_TENSOR);
    return st ? st : take_tensor_type(r, type, p);
}

/* ---- the whole ---------------------------------------------------------------------------------------------------------- */

static lt_status make_lists(reader *r, pb_span m, lt_onnx_model *out)
{
    int n[32];
    lt_status st = count_fields(r, m, n);

    if (st == LT_OK)
        st = take(r, m.at, (size_t)n[GRAPH_NODE], sizeof(*out->node), &out->node);
    if (st == LT_OK)
        st = take(r, m.at, (size_t)n[GRAPH_INITIALIZER], sizeof(*out->tensor), &out->tensor);
    if (st == LT_OK)
        st = take(r, m.at, (size_t)n[GRAPH_INPUT], sizeof(*out->input), &out->input);
    if (st == LT_OK)
        st = take(r, m.at, (size_t)n[GRAPH_OUTPUT], sizeof(*out->output), &out->output);
    return st;
}

static lt_status graph_field(reader *r, const pb_field *f, lt_onnx_model *m)
{
    switch (f->number) {
    case GRAPH_NODE: return take_node(r, f, &m->node[m->n_nodes++]);
    case GRAPH_NAME: return take_text(r, f, &m->name);
    case GRAPH_INITIALIZER: return take_tensor(r, f, &m->tensor[m->n_tensors++]);
    case GRAPH_INPUT: return take_port(r, f, &m->input[m->n_inputs++]);
    case GRAPH_OUTPUT: return take_port(r, f, &m->output[m->n_outputs++]);
    case GRAPH_SPARSE_INITIALIZER: return bad(r, f->at, "sparse tensors are not read");
    default: return LT_OK;
    }
}

static lt_status take_graph(reader *r, const pb_field *field, lt_onnx_model *out)
{
    pb_span m = field->body;
    lt_status st = want(r, field, PB_BYTES);

    if (st == LT_OK && r->has_graph)
        st = bad(r, field->at, "a second graph");
    r->has_graph = true;
    if (st == LT_OK)
        st = make_lists(r, m, out);
    while (st == LT_OK && m.at < m.end) {
        pb_field f;

        st = next(r, &m, &f);
        if (st == LT_OK)
            st = graph_field(r, &f, out);
    }
    return st;
}

static lt_status take_opset(reader *r, const pb_field *field, lt_onnx_model *out)
{
    pb_span m = field->body;
    const char *domain = "";
    int64_t version = 0;
    lt_status st = want(r, field, PB_BYTES);

    while (st == LT_OK && m.at < m.end) {
        pb_field f;

        st = next(r, &m, &f);
        if (st == LT_OK && f.number == OPSET_DOMAIN)
            st = take_text(r, &f, &domain);
        if (st == LT_OK && f.number == OPSET_VERSION)
            st = take_int(r, &f, &version);
    }
    if (st || !is_standard(domain))
        return st;
    out->opset = version;
    if (version < FIRST_OPSET || version > LAST_OPSET)
        return bad(r, field->at, "operator set %jd; %d to %d are read", (intmax_t)version, FIRST_OPSET, LAST_OPSET);
    return LT_OK;
}

static lt_status take_meta(reader *r, const pb_field *field, lt_onnx_text *out)
{
    pb_span m = field->body;
    lt_status st = want(r, field, PB_BYTES);

    out->key = out->value = "";
    while (st == LT_OK && m.at < m.end) {
        pb_field f;

        st = next(r, &m, &f);
        if (st == LT_OK && f.number == META_KEY)
            st = take_text(r, &f, &out->key);
        if (st == LT_OK && f.number == META_VALUE)
            st = take_text(r, &f, &out->value);
    }
    return st;
}

static lt_status model_field(reader *r, const pb_field *f, lt_onnx_model *m)
{
    switch (f->number) {
    case MODEL_PRODUCER: return take_text(r, f, &m->producer);
    case MODEL_PRODUCER_VERSION: return take_text(r, f, &m->version);
    case MODEL_GRAPH: return take_graph(r, f, m);
    case MODEL_OPSET: return take_opset(r, f, m);
    case MODEL_META: return take_meta(r, f, &m->meta[m->n_meta++]);
    case MODEL_FUNCTIONS: return bad(r, f->at, "functions of the model's own are not read");
    default: return LT_OK;
    }
}

lt_status lt_onnx_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_onnx_model *out)
{
    reader r = { .arena = arena, .name = name, .bytes = bytes };
    lt_onnx_model m = { .path = lt_arena_strdup(arena, name), .producer = "", .version = "", .name = "" };
    pb_span all = { bytes, bytes + n };
    int count[32];
    lt_status st;

    if (n > INT32_MAX)
        return lt_error(LT_EFORMAT, "%s: %zu bytes, but an ONNX file holds at most %d", name, n, INT32_MAX);
    if (!m.path)
        return lt_error(LT_ENOMEM, "%s: no memory", name);
    r.budget = 16 * n + ((size_t)1 << 16);
    st = count_fields(&r, all, count);
    if (st == LT_OK)
        st = take(&r, bytes, (size_t)count[MODEL_META], sizeof(*m.meta), &m.meta);
    while (st == LT_OK && all.at < all.end) {
        pb_field f;

        st = next(&r, &all, &f);
        if (st == LT_OK)
            st = model_field(&r, &f, &m);
    }
    if (st == LT_OK && (!r.has_graph || !m.opset))
        st = lt_error(LT_EFORMAT, "%s: no ONNX model: has no graph, or says no operator set", name);
    if (st == LT_OK)
        *out = m;
    return st;
}

lt_status lt_onnx_read(lt_arena *arena, const char *path, lt_onnx_model *out)
{
    uint8_t *bytes;
    size_t n;
    const lt_status st = lt_read_file(arena, path, INT32_MAX, &bytes, &n);

    return st ? st : lt_onnx_parse(arena, path, bytes, n, out);
}
