/* SPDX-License-Identifier: Apache-2.0 */
/* From a graph to a plan: passes, the list of steps, memory, parts. */
#include "libtensor/graph/passes/passes.h"
#include "libtensor/graph/plan_internal.h"

#include <string.h>

/* What a view is a view of */
static const lt_tensor *viewed(const lt_tensor *t)
{
    while (t->kind == LT_RESULT && lt_op_is_view(t->node->op))
        t = t->node->in[0];
    return t;
}

/* A parameter may have been resized since it was recorded. */
static lt_status check_params(const lt_graph *g)
{
    char was[LT_SHAPE_TEXT], is[LT_SHAPE_TEXT];

    for (int i = 0; i < g->n_tensors; i++) {
        const lt_tensor *t = g->tensor[i];

        if (t->param && !lt_same_shape(&t->shape, &t->param->shape))
            return lt_error(LT_ESHAPE, "the graph has \"%s\" as %s, and now it is %s; record the graph again", t->name,
                            lt_shape_text(&t->shape, was), lt_shape_text(&t->param->shape, is));
    }
    return LT_OK;
}

static lt_status check(const lt_graph *g, const lt_compile_opts *o)
{
    char text[LT_SHAPE_TEXT];

    const lt_status stray = lt_take_stray_error();

    if (stray)
        return stray;
    if (!g)
        return lt_error(LT_EINVAL, "there is no graph to compile");
    if (g->status)
        return lt_graph_status(g);
    if (o->train && !o->loss)
        return lt_error(LT_EINVAL, "a training plan needs a loss");
    if (o->parts > 1 && !(o->train && o->replace_grads))
        return lt_error(LT_EINVAL, "a batch in %d parts, where only a training plan that replaces gradients has parts",
                        o->parts);
    if (o->loss && o->loss->graph != g)
        return o->loss->graph->status ? lt_graph_status(o->loss->graph)
                                      : lt_error(LT_EINVAL, "the loss belongs to another graph");
    if (o->train && viewed(o->loss)->kind != LT_RESULT)
        return lt_error(LT_EINVAL, "the loss is \"%s\" itself, want a result", viewed(o->loss)->name);
    if (o->loss && lt_numel(o->loss) != 1)
        return lt_error(LT_ESHAPE, "the loss is %s, want one number", lt_shape_text(&o->loss->shape, text));
    return check_params(g);
}

static lt_status run_passes(lt_plan *p, const lt_graph *source, const lt_compile_opts *o)
{
    const bool simplify = !o->train && !o->no_fusion;              /* for inference */
    lt_status st;

    p->of = lt_arena_array(p->arena, (size_t)source->n_tensors, sizeof(*p->of));
    if (!p->of)
        return lt_error(LT_ENOMEM, "no memory to compile the graph");
    p->recorded = source;
    p->n_of = source->n_tensors;
    p->g = pass_copy(source, !o->train, p->of);
    if (!p->g)
        return LT_ENOMEM;
    if (o->loss) {
        p->loss = p->of[o->loss->id];
        p->loss->is_output = true;
    }
    st = pass_dead_code(p->g);
    if (st == LT_OK && simplify)
        st = pass_fuse(p->g);
    if (st == LT_OK && o->train && !o->no_fusion)
        st = pass_fuse_for_training(p->g);
    if (st == LT_OK && simplify && !o->int8)
        st = pass_block(p->g);
    if (st == LT_OK && simplify && !o->int8)
        st = pass_pair(p->g);
    if (st == LT_OK && simplify)
        st = pass_prepare(p->g, o->int8);
    return st;
}

static lt_status allocate_info(lt_plan *p)
{
    p->tensor = lt_arena_array(p->arena, (size_t)p->g->n_tensors, sizeof(*p->tensor));
    p->node = lt_arena_array(p->arena, (size_t)p->g->n_nodes, sizeof(*p->node));
    p->prologue = lt_arena_array(p->arena, (size_t)p->g->n_nodes, sizeof(*p->prologue));
    if (!p->tensor || !p->node || !p->prologue)
        return lt_error(LT_ENOMEM, "no memory to compile the graph");
    for (int i = 0; i < p->g->n_tensors; i++)
        p->tensor[i] = (plan_tensor){ .root = i, .value = -1, .again = -1, .grad = -1 };
    for (int k = 0; k < p->g->n_nodes; k++) {
        const lt_node *n = p->g->node[k];

        for (int i = 0; i < LT_MAX_SAVED; i++)
            p->node[k].saved[i] = -1;
        if (n && lt_op_is_view(n->op))
            p->tensor[n->outs[0]->id].root = p->tensor[n->in[0]->id].root;
    }
    return LT_OK;
}

/* The sets that the graph's parameters are of: one, as a rule. */
static lt_status list_sets(lt_plan *p)
{
    size_t room = 0;

    for (int i = 0; i < p->g->n_tensors; i++) {
        const lt_param *param = p->g->tensor[i]->param;
        int k = 0;

        while (param && k < p->n_sets && p->set[k].set != param->set)
            k++;
        if (!param || k < p->n_sets)
            continue;
        p->set = lt_arena_grow(p->arena, p->set, (size_t)p->n_sets, &room, sizeof(*p->set));
        if (!p->set)
            return lt_error(LT_ENOMEM, "no memory to compile the graph");
        p->set[p->n_sets++] = (struct plan_set){ .set = param->set, .moves = lt_params_moves(param->set) };
    }
    return LT_OK;
}

static lt_status add_forward(lt_plan *p)
{
    for (int k = 0; k < p->g->n_nodes; k++) {
        lt_node *n = p->g->node[k];

        if (!n || lt_op_is_view(n->op))
            continue;
        p->node[k].constant = !p->train && n->constant;
        if (p->node[k].constant)
            p->prologue[p->n_prologue++] = (plan_step){ .kind = STEP_FORWARD, .node = n };
        else if (!plan_add_step(p, STEP_FORWARD, n))
            return lt_error(LT_ENOMEM, "no memory to compile the graph");
    }
    p->n_forward = p->n_steps;
    return LT_OK;
}

static void ask_for_memory(lt_plan *p)
{
    for (int k = 0; k < p->g->n_nodes; k++) {
        lt_node *n = p->g->node[k];
        lt_call c;

        if (!n || !n->op->plan)
            continue;
        lt_call_init(&c, n);
        c.train = p->train && p->node[k].active;
        n->op->plan(&c);
        memcpy(p->node[k].saved_bytes, c.saved_bytes, sizeof(c.saved_bytes));
        p->node[k].work_bytes = c.work_bytes;
    }
}

static lt_status compile(lt_plan *p, const lt_graph *source, const lt_compile_opts *o)
{
    lt_status st = run_passes(p, source, o);

    if (st == LT_OK)
        st = allocate_info(p);
    if (st == LT_OK)
        st = list_sets(p);
    if (st == LT_OK)
        st = add_forward(p);
    if (st == LT_OK && p->train)
        st = plan_autodiff(p, !o->no_recompute);
    if (st)
        return st;
    ask_for_memory(p);
    return plan_memory(p);
}

/* An empty plan, the first of so many parts; NULL without memory */
static lt_plan *new_plan(int parts)
{
    lt_arena *arena = lt_arena_new();
    lt_plan *p = arena ? lt_arena_alloc(arena, sizeof(*p)) : NULL;
    lt_plan **part = p ? lt_arena_array(arena, (size_t)parts, sizeof(*part)) : NULL;

    if (!part) {
        lt_arena_free(arena);
        lt_error(LT_ENOMEM, "no memory for a plan");
        return NULL;
    }
    p->arena = arena;
    p->part = part;
    p->part[p->n_parts++] = p;
    p->loss_weight = 1;
    return p;
}

static lt_plan *compile_part(const lt_graph *g, const lt_compile_opts *o, bool later)
{
    lt_plan *p = new_plan(later ? 1 : (int)lt_max_i64(1, o->parts));

    if (!p)
        return NULL;
    p->train = o->train;
    p->replace_grads = o->replace_grads;
    p->later_part = later;
    if (compile(p, g, o)) {
        lt_plan_free(p);
        return NULL;
    }
    return p;
}

static lt_status add_parts(lt_plan *first, const lt_graph *g, const lt_compile_opts *o)
{
    while (first->n_parts < o->parts) {
        lt_plan *p = compile_part(g, o, true);

        if (!p)
            return LT_ENOMEM;
        first->part[first->n_parts++] = p;
    }
    return plan_join_parts(first);
}

lt_plan *lt_compile(lt_graph *g, const lt_compile_opts *opts)
{
    static const lt_compile_opts defaults;
    const lt_compile_opts *o = opts ? opts : &defaults;
    lt_plan *p;

    if (lt_kernels_init() || check(g, o))
        return NULL;
    p = compile_part(g, o, false);
    if (!p)
        return NULL;
    if (o->parts > 1 && add_parts(p, g, o)) {
        lt_plan_free(p);
        return NULL;
    }
    if (o->consume_params && !o->train)
        plan_consume(p);
    else
        lt_plan_refresh(p);
    return p;
}

void lt_plan_free(lt_plan *p)
{
    if (!p)
        return;
    for (int i = 1; i < p->n_parts; i++)
        lt_plan_free(p->part[i]);
    lt_graph_free(p->g);
    lt_release(p->memory);
    lt_arena_free(p->arena);
}
