/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Describing a graph in ONNX's words: the walk over its nodes, and what its values are called. The words that ops
 * use are in words.c.
 */
#include "libtensor/graph/onnx/internal.h"

#include <stdio.h>
#include <string.h>

/* ---- values and their names --------------------------------------------------------------------------------- */

/* Results that are outputs of the graph have names of their own already. */
static const char *result_name(lt_onnx *w, const lt_tensor *t)
{
    char suffix[32] = "";

    for (int i = 1; i < t->node->n_out; i++)
        if (t->node->outs[i] == t)
            snprintf(suffix, sizeof(suffix), ":%d", i);
    return t->is_output ? t->name : lt_onnx_name_of(w, t->node, suffix);
}

/* Made by the operator before, and not named yet: nobody knows it */
static bool is_new(const lt_onnx *w, const char *value)
{
    const lt_onnx_node *last = w->model.n_nodes ? &w->model.node[w->model.n_nodes - 1] : NULL;

    return last && last->out[0] == value && last->name == value;
}

/* A value that was just made is renamed; one that others may know already gets a second name, if one is needed. */
const char *lt_onnx_is(lt_onnx *w, const lt_tensor *t, const char *value)
{
    if (w->status)
        return "";
    if (is_new(w, value))
        value = w->model.node[w->model.n_nodes - 1].out[0] = result_name(w, t);
    else if (t->is_output)
        return lt_onnx_is(w, t, LT_ONNX(w, "Identity", value));
    w->value[t->id] = value;
    return value;
}

static lt_onnx_type type_of(lt_onnx *w, const lt_tensor *t)
{
    if (t->dtype != LT_F32 && t->dtype != LT_I32)
        lt_onnx_fail(w, LT_EINVAL, "\"%s\" is neither of reals nor of 32-bit indices", t->name);
    return t->dtype == LT_I32 ? LT_ONNX_INT32 : LT_ONNX_FLOAT;
}

static const lt_tensor *twin_of(const lt_onnx *w, const lt_tensor *t)
{
    return w->twin ? w->twin->tensor[t->id] : t;
}

int64_t lt_onnx_dim(lt_onnx *w, const lt_tensor *t, int i)
{
    return lt_dim(t, i) == lt_dim(twin_of(w, t), i) ? lt_dim(t, i) : -1;
}

static lt_shape shape_of(lt_onnx *w, const lt_tensor *t)
{
    lt_shape s = { .rank = t->shape.rank };

    for (int i = 0; i < s.rank; i++)
        s.dim[i] = lt_onnx_dim(w, t, i);
    return s;
}

/* A weight or a constant, which must be the same for any batch */
static const char *constant_of(lt_onnx *w, const lt_tensor *t)
{
    const void *data = t->param ? t->param->data : t->data;
    const lt_tensor *twin = twin_of(w, t);
    const char *name = t->param ? t->name : lt_arena_printf(w->arena, "constant.%d", t->id);

    if (!t->param && (!lt_same_shape(&t->shape, &twin->shape) || memcmp(t->data, twin->data, lt_nbytes(t)) != 0))
        lt_onnx_refuse(w, "reads a constant that depends on the batch; give the batch a fixed size");
    return lt_onnx_add_tensor(w, name, type_of(w, t), t->shape, data, t->dtype == LT_F32);
}

const char *lt_onnx_of(lt_onnx *w, const lt_tensor *t)
{
    if (!t || w->status)
        return "";
    if (w->value[t->id])
        return w->value[t->id];
    if (t->kind == LT_INPUT || t->kind == LT_RESULT) {
        lt_onnx_refuse(w, "reads a value that nobody has described");
        return "";
    }
    return w->value[t->id] = constant_of(w, t);
}

/* ---- the walk ------------------------------------------------------------------------------------------------ */

static lt_status check_twin(const lt_graph *g, const lt_graph *twin)
{
    bool same = g->n_nodes == twin->n_nodes && g->n_tensors == twin->n_tensors;

    for (int i = 0; same && i < g->n_nodes; i++) {
        same = g->node[i]->op == twin->node[i]->op && g->node[i]->n_in == twin->node[i]->n_in;
        for (int k = 0; same && k < g->node[i]->n_in; k++) {
            const lt_tensor *a = g->node[i]->in[k], *b = twin->node[i]->in[k];

            same = !a == !b && (!a || (a->id == b->id && a->shape.rank == b->shape.rank));
        }
    }
    return same ? LT_OK
                : lt_error(LT_EINVAL, "the graph is another one for another batch; give the batch a fixed size");
}

/* All ops without an ONNX form at once, each named once */
static void check_ops(lt_onnx *w, const bool *needed)
{
    char names[512] = "";
    size_t n = 0;

    for (int i = 0; i < w->g->n_nodes; i++) {
        const lt_op *op = w->g->node[i]->op;
        char word[80];

        snprintf(word, sizeof(word), " \"%s\"", op->name);
        if (op->onnx || !lt_node_is_needed(w->g->node[i], needed) || strstr(names, word))
            continue;
        if (n + strlen(word) + 1 < sizeof(names))
            n += (size_t)snprintf(names + n, sizeof(names) - n, "%s", word);
    }
    if (n)
        lt_onnx_fail(w, LT_EINVAL, "no ONNX form of%s: such an op has no onnx function", names);
}

static void describe_node(lt_onnx *w, const lt_node *n)
{
    w->at = n;
    w->part = 0;
    n->op->onnx(w, n);
    for (int i = 0; i < n->n_out; i++)
        if (!w->value[n->outs[i]->id])
            lt_onnx_refuse(w, "its onnx function does not say what result %d is", i);
}

/* Inputs and outputs are values of the model, each of which has a name of its own. */
static bool is_taken(const lt_onnx_port *list, int n, const char *name)
{
    for (int i = 0; i < n; i++)
        if (strcmp(list[i].name, name) == 0)
            return true;
    return false;
}

static void add_port(lt_onnx *w, lt_onnx_port *list, int *n, const lt_tensor *t)
{
    const lt_onnx_model *m = &w->model;

    if (is_taken(m->input, m->n_inputs, t->name) || is_taken(m->output, m->n_outputs, t->name))
        lt_onnx_fail(w, LT_EINVAL, "two inputs or outputs are called \"%s\"", t->name);
    list[(*n)++] = (lt_onnx_port){ .name = t->name, .type = type_of(w, t), .shape = shape_of(w, t) };
}

static void describe_ports(lt_onnx *w, const bool *needed)
{
    lt_onnx_model *m = &w->model;

    m->input = lt_onnx_alloc(w, (size_t)w->g->n_tensors, sizeof(*m->input));
    m->output = lt_onnx_alloc(w, (size_t)w->g->n_tensors, sizeof(*m->output));
    for (int i = 0; !w->status && i < w->g->n_tensors; i++) {
        const lt_tensor *t = w->g->tensor[i];

        if (t->kind == LT_INPUT && needed[i]) {
            add_port(w, m->input, &m->n_inputs, t);
            w->value[i] = t->name;
        }
        if (t->is_output && t->kind == LT_RESULT)
            add_port(w, m->output, &m->n_outputs, t);
        else if (t->is_output)
            lt_onnx_fail(w, LT_EINVAL, "output \"%s\" is no result of the graph", t->name);
    }
}

lt_status lt_onnx_describe(lt_arena *arena, const lt_graph *g, const lt_graph *twin, lt_onnx_model *out)
{
    lt_onnx w = { .arena = arena, .g = g, .twin = twin };
    lt_status st = lt_graph_status(g);
    bool *needed;

    if (st == LT_OK && twin)
        st = lt_graph_status(twin) ? lt_graph_status(twin) : check_twin(g, twin);
    if (st)
        return st;
    needed = lt_onnx_alloc(&w, (size_t)g->n_tensors, sizeof(*needed));
    w.value = lt_onnx_alloc(&w, (size_t)g->n_tensors, sizeof(*w.value));
    if (w.status)
        return w.status;
    lt_graph_mark_needed(g, needed);
    check_ops(&w, needed);
    describe_ports(&w, needed);
    for (int i = 0; w.status == LT_OK && i < g->n_nodes; i++)
        if (lt_node_is_needed(g->node[i], needed))
            describe_node(&w, g->node[i]);
    w.model.name = "graph";
    w.model.opset = LT_ONNX_OPSET;
    if (w.status == LT_OK)
        *out = w.model;
    return w.status;
}
