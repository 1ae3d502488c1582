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
    c.out.whole = c.out.whole || (rule->whole && c.out.t && onnx_all_whole(&c));
    if (c.status == LT_OK)
        c.status = onnx_status(g, n);
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
