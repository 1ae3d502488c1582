/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/graph/passes/passes.h"

#include <string.h>

/* Everything but nodes' results: inputs, parameters, constants. Their data is shared with the source. */
static bool copy_leaf(lt_graph *g, const lt_tensor *t, lt_tensor **of)
{
    lt_tensor *copy = lt_tensor_new(g, t->kind, t->name, t->dtype, t->shape);

    if (!copy)
        return false;
    copy->data = t->data;
    copy->param = t->param;
    copy->is_output = t->is_output;
    copy->wants_grad = t->wants_grad;
    of[t->id] = copy;
    return true;
}

static bool copy_results(lt_graph *g, const lt_node *n, lt_node *copy, lt_tensor **of)
{
    for (int i = 0; i < n->n_out; i++) {
        const lt_tensor *t = n->outs[i];
        lt_tensor *out = lt_tensor_new(g, LT_RESULT, t->name, t->dtype, t->shape);

        if (!out)
            return false;
        out->node = copy;
        out->is_output = t->is_output;
        copy->outs[i] = of[t->id] = out;
    }
    return true;
}

static bool copy_node(lt_graph *g, const lt_node *n, lt_tensor **of)
{
    lt_node *copy = lt_arena_alloc(g->arena, sizeof(*copy));

    if (!copy)
        return false;
    *copy = *n;
    copy->attr = lt_arena_alloc(g->arena, n->attr_bytes);
    if (!copy->attr)
        return false;
    memcpy(copy->attr, n->attr, n->attr_bytes);
    for (int i = 0; i < n->n_in; i++)
        copy->in[i] = n->in[i] ? of[n->in[i]->id] : NULL;
    return copy_results(g, n, copy, of) && lt_graph_add_node(g, copy);
}

/* The simpler form takes the name and the duties of what it stands for. */
static bool lowered(const lt_node *n, lt_tensor **of)
{
    lt_tensor *in[LT_MAX_IN], *out;

    for (int i = 0; i < n->n_in; i++)
        in[i] = n->in[i] ? of[n->in[i]->id] : NULL;
    out = n->op->lower(n, in);
    if (!out)
        return false;
    if (n->outs[0]->is_output)
        lt_output(out, n->outs[0]->name);
    of[n->outs[0]->id] = out;
    return true;
}

lt_graph *pass_copy(const lt_graph *source, bool lower, lt_tensor **of)
{
    lt_graph *g = lt_graph_new();
    bool ok = g != NULL;

    for (int i = 0; ok && i < source->n_tensors; i++)
        if (source->tensor[i]->kind != LT_RESULT)
            ok = copy_leaf(g, source->tensor[i], of);
    for (int i = 0; ok && i < source->n_nodes; i++) {
        const lt_node *n = source->node[i];

        g->scope = n->name;
        if (!(lower && n->op->lower && lowered(n, of)))
            ok = copy_node(g, n, of);
    }
    if (ok && g->status == LT_OK)
        return g;
    lt_error(LT_ENOMEM, "no memory to compile the graph");
    if (g)
        lt_graph_status(g);
    lt_graph_free(g);
    return NULL;
}
