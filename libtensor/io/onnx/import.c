/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A model becomes a graph: values by name, node after node, each by its operator's rule.
 */
#include "libtensor/io/onnx/import.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- values by name -------------------------------------------------------------------------------------------- */

/* Open addressing, at most half full */
typedef struct {
    onnx_value *place;
    size_t mask;
    int64_t listed;                 /* numbers that nodes have made of known ones */
} table;

static onnx_value *place_of(const table *t, const char *name)
{
    uint64_t hash = 0xcbf29ce484222325;                 /* FNV-1a */
    size_t i;

    for (const char *c = name; *c; c++)
        hash = (hash ^ (uint8_t)*c) * 0x100000001b3;
    for (i = (size_t)(hash ^ hash >> 32); t->place[i & t->mask].name; i++)
        if (strcmp(t->place[i & t->mask].name, name) == 0)
            break;
    return &t->place[i & t->mask];
}

static lt_status make_table(lt_arena *arena, const lt_onnx_model *m, table *t)
{
    size_t n = (size_t)m->n_inputs + (size_t)m->n_tensors, places = 16;

    for (int i = 0; i < m->n_nodes; i++)
        n += (size_t)m->node[i].n_out;
    while (places < 2 * n)
        places *= 2;
    t->mask = places - 1;
    t->listed = 0;
    t->place = lt_arena_array(arena, places, sizeof(*t->place));
    return t->place ? LT_OK : lt_error(LT_ENOMEM, "no memory for %zu values", n);
}

static lt_status add_value(const table *t, const char *name, onnx_value value)
{
    onnx_value *place = place_of(t, name);

    if (place->name)
        return lt_error(LT_EFORMAT, "value \"%s\" is made twice", name);
    value.name = name;
    *place = value;
    return LT_OK;
}

/* ---- what rules ask for ------------------------------------------------------------------------------------------ */

void onnx_fail(onnx_call *c, const char *fmt, ...)
{
    char why[512];
    va_list args;

    if (c->status)
        return;
    va_start(args, fmt);
    vsnprintf(why, sizeof(why), fmt, args);
    va_end(args);
    c->status = lt_error(LT_EFORMAT, "%s \"%s\": %s", c->node->op, c->node->name, why);
}

void onnx_no_memory(onnx_call *c)
{
    if (c->status == LT_OK)
        c->status = lt_error(LT_ENOMEM, "%s \"%s\": no memory", c->node->op, c->node->name);
}

/* A graph that cannot be is the file's mistake. */
static lt_status status_of(const lt_graph *g, const lt_onnx_node *n)
{
    const lt_status st = lt_graph_status(g);

    return st ? lt_error_prefix(st == LT_ENOMEM ? st : LT_EFORMAT, "%s \"%s\"", n->op, n->name) : LT_OK;
}

/* A constant to be filled, or NULL: what a rule says of the harmless tensor then does not count. */
static lt_real *constant_new(onnx_call *c, lt_shape shape, lt_tensor **out)
{
    lt_real *x = lt_constant_reals(c->g, shape, out);

    if (!x && c->status == LT_OK)
        c->status = status_of(c->g, c->node);
    return x;
}

/* Constants are tensors from when someone wants them as such: shapes and indices never are. */
static lt_tensor *constant_tensor(onnx_call *c, const lt_onnx_tensor *k)
{
    const size_t n = (size_t)lt_shape_numel(&k->shape);
    lt_tensor *t;
    lt_real *x = constant_new(c, k->shape, &t);

    for (size_t i = 0; x && i < n; i++) {
        float f;

        memcpy(&f, (const char *)k->data + i * sizeof(f), sizeof(f));
        x[i] = f;
    }
    return t;
}

lt_tensor *onnx_tensor(onnx_call *c, int i)
{
    onnx_value *v = i < c->n_in ? c->in[i] : NULL;

    if (v && !v->t && v->constant)
        v->t = constant_tensor(c, v->constant);
    if (v && !v->t)
        onnx_fail(c, "input %d holds whole numbers, want reals", i);
    return v ? v->t : NULL;
}

bool onnx_is_known(const onnx_call *c, int i)
{
    return i < c->n_in && c->in[i] && c->in[i]->ints;
}

const int64_t *onnx_ints(onnx_call *c, int i, int *n)
{
    static const int64_t none[1];

    *n = 0;
    if (!onnx_is_known(c, i)) {
        onnx_fail(c, "input %d is not known before the model runs, which is wanted", i);
        return none;
    }
    *n = (int)lt_shape_numel(&c->in[i]->shape);
    return c->in[i]->ints;
}

bool onnx_charge(onnx_call *c, int64_t n)
{
    if (n > ONNX_MAX_LISTED - *c->listed)
        onnx_fail(c, "%jd known numbers, more than %d with those of the nodes before", (intmax_t)n, ONNX_MAX_LISTED);
    else
        *c->listed += n;
    return c->status == LT_OK;
}

int64_t *onnx_list(onnx_call *c, int64_t n)
{
    int64_t *list = onnx_charge(c, n) ? lt_arena_array(c->arena, (size_t)n, sizeof(*list)) : NULL;

    if (!list)
        onnx_no_memory(c);              /* a failure before this one stays */
    return list;
}

lt_tensor *onnx_reals(onnx_call *c, int i, lt_shape shape)
{
    int n;
    const int64_t *whole = onnx_ints(c, i, &n);
    lt_tensor *t;
    lt_real *x = constant_new(c, shape, &t);

    for (int k = 0; x && k < n; k++)
        x[k] = (lt_real)whole[k];
    return t;
}

lt_shape onnx_shape(const onnx_call *c, int i)
{
    const onnx_value *v = i < c->n_in ? c->in[i] : NULL;

    if (!v)
        return (lt_shape){ 0 };
    return v->ints ? v->shape : v->t ? v->t->shape : v->constant->shape;
}

const lt_onnx_attr *onnx_attr(const onnx_call *c, const char *name)
{
    for (int i = 0; i < c->node->n_attr; i++)
        if (strcmp(c->node->attr[i].name, name) == 0)
            return &c->node->attr[i];
    return NULL;
}

static const lt_onnx_attr *attr_of_kind(onnx_call *c, const char *name, lt_onnx_attr_kind kind)
{
    const lt_onnx_attr *a = onnx_attr(c, name);

    if (a && a->kind != kind) {
        onnx_fail(c, "attribute \"%s\" is of kind %d, want %d", name, (int)a->kind, (int)kind);
        return NULL;
    }
    return a;
}

static int64_t within(onnx_call *c, const char *name, int64_t x, int64_t lo, int64_t hi)
{
    if (x >= lo && x <= hi)
        return x;
    onnx_fail(c, "attribute \"%s\" is %jd, want %jd to %jd", name, (intmax_t)x, (intmax_t)lo, (intmax_t)hi);
    return lo;
}

int onnx_attr_int(onnx_call *c, const char *name, int64_t fallback, int64_t lo, int64_t hi)
{
    const lt_onnx_attr *a = attr_of_kind(c, name, LT_ONNX_A_INT);

    return (int)within(c, name, a ? a->i : fallback, lo, hi);
}

int onnx_attr_equal(onnx_call *c, const char *name, int n, int64_t fallback, int64_t lo, int64_t hi)
{
    const lt_onnx_attr *a = attr_of_kind(c, name, LT_ONNX_A_INTS);

    if (!a)
        return (int)within(c, name, fallback, lo, hi);
    if (a->n_ints != n)
        onnx_fail(c, "attribute \"%s\" has %d numbers, want %d", name, a->n_ints, n);
    for (int i = 1; i < a->n_ints; i++)
        if (a->ints[i] != a->ints[0])
            onnx_fail(c, "attribute \"%s\" has numbers that differ, want equal ones", name);
    return (int)within(c, name, a->n_ints ? a->ints[0] : lo, lo, hi);
}

int onnx_axis(onnx_call *c, int64_t fallback)
{
    const int rank = onnx_shape(c, 0).rank, axis = onnx_attr_int(c, "axis", fallback, -rank, rank - 1);

    return axis < 0 ? axis + rank : axis;
}

double onnx_attr_float(onnx_call *c, const char *name, double fallback)
{
    const lt_onnx_attr *a = attr_of_kind(c, name, LT_ONNX_A_FLOAT);

    return a ? (double)a->f : fallback;
}

bool onnx_attr_is(onnx_call *c, const char *name, const char *fallback, const char *value)
{
    const lt_onnx_attr *a = attr_of_kind(c, name, LT_ONNX_A_TEXT);

    return strcmp(a ? a->text : fallback, value) == 0;
}

/* ---- the walk ---------------------------------------------------------------------------------------------------- */

static void check_attrs(onnx_call *c, const onnx_rule *rule)
{
    for (int i = 0; i < c->node->n_attr; i++) {
        char word[64];

        snprintf(word, sizeof(word), " %s ", c->node->attr[i].name);
        if (strlen(c->node->attr[i].name) > 60 || !strstr(rule->attrs, word))
            onnx_fail(c, "attribute \"%s\" is not understood", c->node->attr[i].name);
    }
}

static void find_inputs(onnx_call *c, const onnx_rule *rule, const table *values)
{
    c->n_in = c->node->n_in;
    if (c->n_in < rule->min_in || c->n_in > rule->max_in) {
        onnx_fail(c, "%d inputs, want %d to %d", c->n_in, rule->min_in, rule->max_in);
        return;
    }
    for (int i = 0; i < c->n_in; i++) {
        const char *name = c->node->in[i];
        onnx_value *v = *name ? place_of(values, name) : NULL;

        if (v && !v->name)
            onnx_fail(c, "input \"%s\" has not been made before", name);
        else if (!v && i < rule->min_in)
            onnx_fail(c, "input %d is missing", i);
        c->in[i] = v;
    }
}

static lt_status record_node(lt_arena *arena, lt_graph *g, int64_t opset, const lt_onnx_node *n, table *values)
{
    const onnx_rule *rule = onnx_rule_find(n->op);
    onnx_call c = { .arena = arena, .g = g, .opset = opset, .node = n, .listed = &values->listed };

    if (!rule)
        return lt_error(LT_EFORMAT, "%s \"%s\": this operator is not understood", n->op, n->name);
    if (n->n_out != 1)
        onnx_fail(&c, "%d results, want one", n->n_out);
    check_attrs(&c, rule);
    find_inputs(&c, rule, values);
    lt_scope(g, n->name);
    if (c.status == LT_OK)
        rule->record(&c);
    if (c.status == LT_OK)
        c.status = status_of(g, n);
    if (c.status == LT_OK && !c.out.t && !c.out.ints)
        onnx_fail(&c, "has no result");
    return c.status ? c.status : add_value(values, n->out[0], c.out);
}

static lt_status add_constant(lt_arena *arena, const table *values, const lt_onnx_tensor *t)
{
    const size_t n = (size_t)lt_shape_numel(&t->shape);
    onnx_value v = { .shape = t->shape };
    int64_t *ints;

    if (t->type == LT_ONNX_FLOAT) {
        v.constant = t;
        return add_value(values, t->name, v);
    }
    v.ints = ints = lt_arena_array(arena, n, sizeof(*ints));
    if (!ints)
        return lt_error(LT_ENOMEM, "no memory for \"%s\"", t->name);
    for (size_t i = 0; i < n; i++) {
        int32_t narrow;

        if (t->type == LT_ONNX_INT64) {
            memcpy(&ints[i], (const char *)t->data + 8 * i, 8);
        } else {
            memcpy(&narrow, (const char *)t->data + 4 * i, 4);
            ints[i] = narrow;
        }
    }
    return add_value(values, t->name, v);
}

static lt_status add_input(lt_graph *g, const table *values, const lt_onnx_port *p, int64_t batch, lt_tensor **out)
{
    lt_shape shape = p->shape;

    for (int i = 0; i < shape.rank; i++)
        shape.dim[i] = shape.dim[i] < 0 ? batch : shape.dim[i];
    *out = lt_input(g, p->name, p->type == LT_ONNX_INT32 ? LT_I32 : LT_F32, shape.rank, shape.dim);
    return lt_graph_status(g) ? lt_graph_status(g) : add_value(values, p->name, (onnx_value){ .t = *out });
}

static lt_status add_output(const table *values, const lt_onnx_port *p, lt_tensor **out)
{
    const onnx_value *v = place_of(values, p->name);

    if (!v->name || !v->t || v->t->kind != LT_RESULT)
        return lt_error(LT_EFORMAT, "output \"%s\" is no result of the graph", p->name);
    if (v->t->is_output)
        return lt_error(LT_EFORMAT, "output \"%s\" is another output too", p->name);
    *out = lt_output(v->t, p->name);
    return LT_OK;
}

lt_status lt_onnx_import(lt_arena *arena, lt_graph *g, const lt_onnx_model *m, int64_t batch, lt_onnx_ports *ports)
{
    table values;
    lt_status st = make_table(arena, m, &values);

    ports->input = lt_arena_array(arena, (size_t)m->n_inputs, sizeof(*ports->input));
    ports->output = lt_arena_array(arena, (size_t)m->n_outputs, sizeof(*ports->output));
    if (st == LT_OK && (!ports->input || !ports->output))
        st = lt_error(LT_ENOMEM, "no memory for the model's ports");
    for (int i = 0; st == LT_OK && i < m->n_inputs; i++)
        st = add_input(g, &values, &m->input[i], batch, &ports->input[i]);
    for (int i = 0; st == LT_OK && i < m->n_tensors; i++)
        st = add_constant(arena, &values, &m->tensor[i]);
    for (int i = 0; st == LT_OK && i < m->n_nodes; i++)
        st = record_node(arena, g, m->opset, &m->node[i], &values);
    for (int i = 0; st == LT_OK && i < m->n_outputs; i++)
        st = add_output(&values, &m->output[i], &ports->output[i]);
    return st && m->path ? lt_error_prefix(st, "%s", m->path) : st;
}
