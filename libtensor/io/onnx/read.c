/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Bytes of a stranger as a model: one function for each message of onnx.proto. Lists are counted before they
 * are allocated, all memory comes from a budget that the file's size sets, and nesting is as deep as these
 * functions call each other.
 */
#include "libtensor/io/file.h"
#include "libtensor/io/kind.h"
#include "libtensor/io/onnx/fields.h"
#include "libtensor/io/onnx/reader.h"

#include <string.h>

enum { FIRST_OPSET = 11, LAST_OPSET = 20 };

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

/* What an attribute's lists and tensor have room for */
typedef struct {
    int64_t *ints;
    float *floats;
    lt_onnx_tensor *tensor;
    size_t n_ints, n_floats, n_tensors;
} attr_room;

/* Numbers may be packed: whole ones are as many as they have bytes at most. */
static lt_status make_room(onnx_reader *r, pb_span m, attr_room *room)
{
    pb_field f;
    lt_status st = LT_OK;

    while (onnx_next(r, &m, &f, &st))
        switch (f.number) {
        case ATTR_INTS: room->n_ints += f.wire == PB_BYTES ? pb_size(f.body) : 1; break;
        case ATTR_FLOATS: room->n_floats += f.wire == PB_BYTES ? pb_size(f.body) / sizeof(float) : 1; break;
        case ATTR_T: room->n_tensors++; break;
        default: break;
        }
    if (st == LT_OK && (room->n_ints > INT32_MAX || room->n_floats > INT32_MAX))
        st = onnx_bad(r, m.at, "a list of more than 2^31 numbers");
    if (st == LT_OK && room->n_tensors > 1)
        st = onnx_bad(r, m.at, "an attribute of several tensors");
    if (st == LT_OK)
        st = onnx_take(r, m.at, room->n_ints, sizeof(*room->ints), &room->ints);
    if (st == LT_OK)
        st = onnx_take(r, m.at, room->n_floats, sizeof(*room->floats), &room->floats);
    if (st == LT_OK && room->n_tensors)
        st = onnx_take(r, m.at, 1, sizeof(*room->tensor), &room->tensor);
    return st;
}

static lt_status attr_field(onnx_reader *r, const pb_field *f, const attr_room *room, lt_onnx_attr *a)
{
    const uint32_t bits = (uint32_t)f->value;
    int64_t kind;
    lt_status st;

    switch (f->number) {
    case ATTR_NAME: return onnx_take_text(r, f, &a->name);
    case ATTR_S: return onnx_take_text(r, f, &a->text);
    case ATTR_I: return onnx_take_int(r, f, &a->i);
    case ATTR_INTS: return onnx_add_ints(r, f, room->ints, (int)room->n_ints, &a->n_ints);
    case ATTR_FLOATS: return onnx_add_floats(r, f, room->floats, (int)room->n_floats, &a->n_floats);
    case ATTR_T:
        a->tensor = room->tensor;
        return onnx_take_tensor(r, f, room->tensor);
    case ATTR_F:
        memcpy(&a->f, &bits, sizeof(bits));
        return onnx_want(r, f, PB_FIXED32);
    case ATTR_TYPE:
        st = onnx_take_int(r, f, &kind);
        a->kind = (lt_onnx_attr_kind)kind;
        return st;
    default: return LT_OK;
    }
}

static bool is_read(lt_onnx_attr_kind kind)
{
    return kind == LT_ONNX_A_FLOAT || kind == LT_ONNX_A_INT || kind == LT_ONNX_A_TEXT || kind == LT_ONNX_A_TENSOR
        || kind == LT_ONNX_A_FLOATS || kind == LT_ONNX_A_INTS;
}

static lt_status take_attr(onnx_reader *r, const pb_field *field, lt_onnx_attr *a)
{
    pb_span m = field->body;
    attr_room room = { 0 };
    pb_field f;
    lt_status st = onnx_want(r, field, PB_BYTES);

    a->name = a->text = "";
    if (st == LT_OK)
        st = make_room(r, m, &room);
    a->ints = room.ints;
    a->floats = room.floats;
    while (onnx_next(r, &m, &f, &st))
        st = attr_field(r, &f, &room, a);
    if (st == LT_OK && !is_read(a->kind))
        st = onnx_bad(r, field->at, "attribute \"%s\" is of kind %d; a number, numbers, a text or a tensor are read, "
                      "no graphs", a->name, (int)a->kind);
    if (st == LT_OK && a->kind == LT_ONNX_A_TENSOR && !a->tensor)
        st = onnx_bad(r, field->at, "attribute \"%s\" has no tensor", a->name);
    return st;
}

static lt_status node_field(onnx_reader *r, const pb_field *f, lt_onnx_node *n, const char **domain)
{
    switch (f->number) {
    case NODE_INPUT: return onnx_take_text(r, f, &n->in[n->n_in++]);
    case NODE_OUTPUT: return onnx_take_text(r, f, &n->out[n->n_out++]);
    case NODE_NAME: return onnx_take_text(r, f, &n->name);
    case NODE_OP: return onnx_take_text(r, f, &n->op);
    case NODE_ATTRIBUTE: return take_attr(r, f, &n->attr[n->n_attr++]);
    case NODE_DOMAIN: return onnx_take_text(r, f, domain);
    default: return LT_OK;
    }
}

static bool is_standard(const char *domain)
{
    return !*domain || strcmp(domain, "ai.onnx") == 0;
}

static lt_status take_node(onnx_reader *r, const pb_field *field, lt_onnx_node *n)
{
    pb_span m = field->body;
    const char *domain = "";
    int count[ONNX_COUNTED];
    pb_field f;
    lt_status st = onnx_want(r, field, PB_BYTES);

    n->op = n->name = "";
    if (st == LT_OK)
        st = onnx_count_fields(r, m, count);
    if (st == LT_OK)
        st = onnx_take(r, field->at, (size_t)count[NODE_INPUT], sizeof(*n->in), &n->in);
    if (st == LT_OK)
        st = onnx_take(r, field->at, (size_t)count[NODE_OUTPUT], sizeof(*n->out), &n->out);
    if (st == LT_OK)
        st = onnx_take(r, field->at, (size_t)count[NODE_ATTRIBUTE], sizeof(*n->attr), &n->attr);
    while (onnx_next(r, &m, &f, &st))
        st = node_field(r, &f, n, &domain);
    if (st == LT_OK && !is_standard(domain))
        st = onnx_bad(r, field->at, "operator \"%s\" is of \"%s\"; standard ones are read", n->op, domain);
    if (st == LT_OK && (!*n->op || n->n_out == 0))
        st = onnx_bad(r, field->at, "a node without an operator or without a result");
    return st;
}

/* ---- inputs and outputs ------------------------------------------------------------------------------------------ */

/* The field of a message that holds the next message; nothing when it is missing */
static lt_status enter(const onnx_reader *r, pb_span *m, int number)
{
    pb_span found = { m->end, m->end };
    pb_field f;
    lt_status st = LT_OK;

    while (onnx_next(r, m, &f, &st))
        if (f.number == number) {
            st = onnx_want(r, &f, PB_BYTES);
            found = f.body;
        }
    *m = found;
    return st;
}

/* A size, or -1 and a name where it is open */
static lt_status take_dim(onnx_reader *r, pb_span m, int64_t *dim, const char **open)
{
    pb_field f;
    lt_status st = LT_OK;

    *dim = -1;
    while (onnx_next(r, &m, &f, &st)) {
        if (f.number == DIM_VALUE)
            st = onnx_take_int(r, &f, dim);
        if (f.number == DIM_PARAM)
            st = onnx_take_text(r, &f, open);
        if (st == LT_OK && *dim < -1)
            st = onnx_bad(r, f.at, "a dimension below 0");
    }
    return st;
}

static lt_status take_dims(onnx_reader *r, pb_span m, lt_onnx_port *p)
{
    pb_field f;
    lt_status st = LT_OK;

    while (onnx_next(r, &m, &f, &st)) {
        if (f.number != SHAPE_DIM)
            continue;
        st = onnx_want(r, &f, PB_BYTES);
        if (st == LT_OK && p->shape.rank == LT_MAX_RANK)
            st = onnx_bad(r, f.at, "more than %d dimensions", LT_MAX_RANK);
        if (st == LT_OK) {
            st = take_dim(r, f.body, &p->shape.dim[p->shape.rank], &p->open[p->shape.rank]);
            p->shape.rank++;
        }
    }
    return st;
}

static lt_status take_tensor_type(onnx_reader *r, pb_span m, lt_onnx_port *p)
{
    int64_t type = 0;
    const uint8_t *at = m.at;
    pb_field f;
    lt_status st = LT_OK;

    while (onnx_next(r, &m, &f, &st)) {
        if (f.number == TENSOR_TYPE_ELEM)
            st = onnx_take_int(r, &f, &type);
        if (f.number == TENSOR_TYPE_SHAPE)
            st = onnx_want(r, &f, PB_BYTES) ? LT_EFORMAT : take_dims(r, f.body, p);
    }
    if (st == LT_OK && type != LT_ONNX_FLOAT && type != LT_ONNX_INT32)
        st = onnx_bad(r, at, "\"%s\" is of type %jd; 1 (FLOAT) and 6 (INT32) are read", p->name, (intmax_t)type);
    p->type = (lt_onnx_type)type;
    return st;
}

static lt_status take_port(onnx_reader *r, const pb_field *field, lt_onnx_port *p)
{
    pb_span m = field->body, type = { NULL, NULL };
    pb_field f;
    lt_status st = onnx_want(r, field, PB_BYTES);

    p->name = "";
    while (onnx_next(r, &m, &f, &st)) {
        if (f.number == VALUE_NAME)
            st = onnx_take_text(r, &f, &p->name);
        if (f.number == VALUE_TYPE) {
            st = onnx_want(r, &f, PB_BYTES);
            type = f.body;
        }
    }
    if (st == LT_OK && (!*p->name || !type.at))
        st = onnx_bad(r, field->at, "an input or output without a name or a type");
    if (st == LT_OK)
        st = enter(r, &type, TYPE_TENSOR);
    return st ? st : take_tensor_type(r, type, p);
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static lt_status make_lists(onnx_reader *r, pb_span m, lt_onnx_model *out)
{
    int n[ONNX_COUNTED];
    lt_status st = onnx_count_fields(r, m, n);

    if (st == LT_OK)
        st = onnx_take(r, m.at, (size_t)n[GRAPH_NODE], sizeof(*out->node), &out->node);
    if (st == LT_OK)
        st = onnx_take(r, m.at, (size_t)n[GRAPH_INITIALIZER], sizeof(*out->tensor), &out->tensor);
    if (st == LT_OK)
        st = onnx_take(r, m.at, (size_t)n[GRAPH_INPUT], sizeof(*out->input), &out->input);
    if (st == LT_OK)
        st = onnx_take(r, m.at, (size_t)n[GRAPH_OUTPUT], sizeof(*out->output), &out->output);
    return st;
}

static lt_status graph_field(onnx_reader *r, const pb_field *f, lt_onnx_model *m)
{
    switch (f->number) {
    case GRAPH_NODE: return take_node(r, f, &m->node[m->n_nodes++]);
    case GRAPH_NAME: return onnx_take_text(r, f, &m->name);
    case GRAPH_INITIALIZER: return onnx_take_tensor(r, f, &m->tensor[m->n_tensors++]);
    case GRAPH_INPUT: return take_port(r, f, &m->input[m->n_inputs++]);
    case GRAPH_OUTPUT: return take_port(r, f, &m->output[m->n_outputs++]);
    case GRAPH_SPARSE_INITIALIZER: return onnx_bad(r, f->at, "sparse tensors are not read");
    default: return LT_OK;
    }
}

static lt_status take_graph(onnx_reader *r, const pb_field *field, lt_onnx_model *out)
{
    pb_span m = field->body;
    pb_field f;
    lt_status st = onnx_want(r, field, PB_BYTES);

    if (st == LT_OK && r->has_graph)
        st = onnx_bad(r, field->at, "a second graph");
    r->has_graph = true;
    if (st == LT_OK)
        st = make_lists(r, m, out);
    while (onnx_next(r, &m, &f, &st))
        st = graph_field(r, &f, out);
    return st;
}

static lt_status take_opset(onnx_reader *r, const pb_field *field, lt_onnx_model *out)
{
    pb_span m = field->body;
    const char *domain = "";
    int64_t version = 0;
    pb_field f;
    lt_status st = onnx_want(r, field, PB_BYTES);

    while (onnx_next(r, &m, &f, &st)) {
        if (f.number == OPSET_DOMAIN)
            st = onnx_take_text(r, &f, &domain);
        if (f.number == OPSET_VERSION)
            st = onnx_take_int(r, &f, &version);
    }
    if (st || !is_standard(domain))
        return st;
    out->opset = version;
    if (version < FIRST_OPSET || version > LAST_OPSET)
        return onnx_bad(r, field->at, "operator set %jd; %d to %d are read", (intmax_t)version, FIRST_OPSET,
                        LAST_OPSET);
    return LT_OK;
}

static lt_status take_meta(onnx_reader *r, const pb_field *field, lt_onnx_text *out)
{
    pb_span m = field->body;
    pb_field f;
    lt_status st = onnx_want(r, field, PB_BYTES);

    out->key = out->value = "";
    while (onnx_next(r, &m, &f, &st)) {
        if (f.number == META_KEY)
            st = onnx_take_text(r, &f, &out->key);
        if (f.number == META_VALUE)
            st = onnx_take_text(r, &f, &out->value);
    }
    return st;
}

static lt_status model_field(onnx_reader *r, const pb_field *f, lt_onnx_model *m)
{
    switch (f->number) {
    case MODEL_PRODUCER: return onnx_take_text(r, f, &m->producer);
    case MODEL_PRODUCER_VERSION: return onnx_take_text(r, f, &m->version);
    case MODEL_GRAPH: return take_graph(r, f, m);
    case MODEL_OPSET: return take_opset(r, f, m);
    case MODEL_META: return take_meta(r, f, &m->meta[m->n_meta++]);
    case MODEL_FUNCTIONS: return onnx_bad(r, f->at, "functions of the model's own are not read");
    default: return LT_OK;
    }
}

lt_status lt_onnx_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_onnx_model *out)
{
    onnx_reader r = { .arena = arena, .name = name, .bytes = bytes };
    lt_onnx_model m = { .path = lt_arena_strdup(arena, name), .producer = "", .version = "", .name = "" };
    pb_span all = { bytes, bytes + n };
    int count[ONNX_COUNTED];
    pb_field f;
    lt_status st;

    st = lt_refuse_other(name, bytes, n, LT_KIND_UNKNOWN, "an ONNX file");
    if (st)
        return st;
    if (n > INT32_MAX)
        return lt_error(LT_EFORMAT, "%s: %zu bytes, but an ONNX file holds at most %d", name, n, INT32_MAX);
    if (!m.path)
        return lt_error(LT_ENOMEM, "%s: no memory", name);
    r.budget = 16 * n + ((size_t)1 << 16);
    st = onnx_count_fields(&r, all, count);
    if (st == LT_OK)
        st = onnx_take(&r, bytes, (size_t)count[MODEL_META], sizeof(*m.meta), &m.meta);
    while (onnx_next(&r, &all, &f, &st))
        st = model_field(&r, &f, &m);
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
