/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A model becomes a graph: values by name, node after node, each by its operator's rule.
 */
#include "libtensor/io/onnx/import.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

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

/* ---- the walk ---------------------------------------------------------------------------------------------------- */

/* Where a rule lists this name: just behind it, or NULL */
static const char *listed(const char *attrs, const char *name)
{
    const size_t n = strlen(name);

    for (const char *at = attrs; (at = strchr(at, ' ')) && *++at; )
        if (n > 0 && strncmp(at, name, n) == 0 && (at[n] == ' ' || at[n] == '='))
            return at + n;
    return NULL;
}

static bool says(const lt_onnx_attr *a, const char *value)
{
    switch (a->kind) {
    case LT_ONNX_A_INT: return a->i == strtoll(value, NULL, 10);
    case LT_ONNX_A_FLOAT: return a->f == strtof(value, NULL);
    case LT_ONNX_A_TEXT: return strcmp(a->text, value) == 0;
    case LT_ONNX_A_INTS:
        for (int i = 0; i < a->n_ints; i++)
            if (a->ints[i] != strtoll(value, NULL, 10))
                return false;
        return true;
    default: return false;
    }
}

static void check_attrs(onnx_call *c, const onnx_rule *rule)
{
    for (int i = 0; i < c->node->n_attr; i++) {
        const lt_onnx_attr *a = &c->node->attr[i];
        const char *rest = listed(rule->attrs, a->name);
        char value[32];

        if (!rest)
            onnx_fail(c, "attribute \"%s\" is not understood", a->name);
        else if (sscanf(rest, "=%31s", value) == 1 && !says(a, value))
            onnx_fail(c, "attribute \"%s\" says something else than %s, which is all that is read", a->name, value);
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

/* Results that are left out have no name. A plan's mistakes name the node, no line of ours. */
static void run_rule(onnx_call *c, const onnx_rule *rule)
{
    lt_scope(c->g, c->node->name);
    lt_here_enter(NULL, 0);
    rule->record(c);
    lt_here_leave(NULL);
    c->out.whole = c->out.whole || (rule->is & ONNX_WHOLE && c->out.t && onnx_all_whole(c));
    if (c->status == LT_OK)
        c->status = onnx_status(c->g, c->node);
    if (c->status == LT_OK && !c->out.t && !c->out.ints && !c->out.constant)
        onnx_fail(c, "has no result");
}

static lt_status add_results(const onnx_call *c, const table *values)
{
    lt_status st = add_value(values, c->node->out[0], c->out);

    for (int i = 1; st == LT_OK && i < c->node->n_out; i++)
        if (c->more[i - 1] && *c->node->out[i])
            st = add_value(values, c->node->out[i], (onnx_value){ .t = c->more[i - 1], .whole = c->out.whole });
    return st;
}

static lt_status record_node(lt_arena *arena, lt_graph *g, int64_t opset, const lt_onnx_node *n, table *values)
{
    const onnx_rule *rule = onnx_rule_find(n->op);
    onnx_call c = { .arena = arena, .g = g, .opset = opset, .node = n, .listed = &values->listed };

    if (!rule)
        return lt_error(LT_EFORMAT, "%s \"%s\": this operator is not understood", n->op, n->name);
    if (n->n_out > (rule->is & ONNX_MANY ? ONNX_MAX_OUT : 1))
        onnx_fail(&c, "%d results, want %s", n->n_out, rule->is & ONNX_MANY ? "16 at most" : "one");
    check_attrs(&c, rule);
    find_inputs(&c, rule, values);
    if (c.status == LT_OK)
        run_rule(&c, rule);
    return c.status ? c.status : add_results(&c, values);
}

static lt_status add_constant(lt_arena *arena, const table *values, const lt_onnx_tensor *t)
{
    onnx_value v;
    const lt_status st = onnx_value_of(arena, t, &v);

    return st ? st : add_value(values, t->name, v);
}

/* The side of a picture, by what a file calls it: "height", "in_Width", "H" */
static bool is_side(const char *name)
{
    if (!name)
        return false;
    for (const char *at = name; *at; at++)
        if (strncasecmp(at, "height", 6) == 0 || strncasecmp(at, "width", 5) == 0)
            return true;
    return strcasecmp(name, "h") == 0 || strcasecmp(name, "w") == 0;
}

/* The batch is the first dimension, and others only by its name. */
static bool is_batch(const lt_onnx_port *p, int i)
{
    if (i == 0)
        return !is_side(p->open[0]);
    return p->shape.dim[0] < 0 && p->open[0] && p->open[i] && strcmp(p->open[0], p->open[i]) == 0;
}

static lt_status add_input(lt_graph *g, const table *values, const lt_onnx_port *p, int64_t batch, lt_tensor **out)
{
    lt_shape shape = p->shape;

    for (int i = 0; i < shape.rank; i++) {
        if (shape.dim[i] < 0 && !is_batch(p, i))
            return lt_error(LT_EFORMAT, "input \"%s\": dimension %d (\"%s\") is open, which only the batch may be; "
                            "export the model with a size there", p->name, i, p->open[i] ? p->open[i] : "");
        shape.dim[i] = shape.dim[i] < 0 ? batch : shape.dim[i];
    }
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
