/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reverse-mode differentiation as a step of compilation: the backward pass becomes ordinary steps, so
 * that forward and backward share one memory plan.
 */
#include "libtensor/graph/plan_internal.h"

static bool differentiable(const lt_op *op)
{
    return !(op->flags & LT_OP_DETACH) && (op->backward || (op->flags & LT_OP_VIEW));
}

static bool leaf_needs_grad(const lt_tensor *t)
{
    return t->dtype == LT_F32
        && ((t->kind == LT_PARAM && !t->param->frozen) || (t->kind == LT_INPUT && t->wants_grad));
}

static void find_who_needs_grad(lt_plan *p)
{
    for (int i = 0; i < p->g->n_tensors; i++)
        p->tensor[i].needs_grad = leaf_needs_grad(p->g->tensor[i]);
    for (int k = 0; k < p->g->n_nodes; k++) {
        const lt_node *n = p->g->node[k];
        bool needs = false;

        for (int i = 0; n && differentiable(n->op) && i < n->n_in; i++)
            needs |= n->in[i] && p->tensor[n->in[i]->id].needs_grad;
        for (int i = 0; n && i < n->n_out; i++)
            p->tensor[n->outs[i]->id].needs_grad = needs && n->outs[i]->dtype == LT_F32;
    }
}

/* Whatever else reads it would write gradients of rows that are in no step. */
static lt_status check_reader(const lt_plan *p, const lt_node *n, int i)
{
    const lt_param *param = plan_root_tensor(p, n->in[i])->param;
    char where[LT_WHERE];

    if (!param || !param->rows || (i == 0 && (n->op->flags & LT_OP_ROWS)))
        return LT_OK;
    return lt_error(LT_EINVAL, "%s%s%s%s: reads all of \"%s\", which is stepped by rows; read those of a step "
                    "with lt_rows%s", n->op->name, *n->name ? " \"" : "", n->name, *n->name ? "\"" : "", param->name,
                    lt_where(n->file, n->line, where));
}

/* An op without a backward pass may not stand between the loss and what it learns: its inputs would silently learn
 * nothing from there. */
static lt_status check_backward(lt_plan *p)
{
    bool *reaches = lt_arena_array(p->arena, (size_t)p->g->n_tensors, sizeof(*reaches));     /* the loss */
    char where[LT_WHERE];

    if (!reaches)
        return lt_error(LT_ENOMEM, "no memory to compile the backward pass");
    reaches[p->loss->id] = true;
    for (int k = p->g->n_nodes - 1; k >= 0; k--) {
        const lt_node *n = p->g->node[k];
        bool reached = false;

        for (int i = 0; n && i < n->n_out; i++)
            reached |= reaches[n->outs[i]->id];
        if (!reached || (n->op->flags & LT_OP_DETACH))
            continue;
        for (int i = 0; i < n->n_in; i++) {
            if (n->in[i] && p->tensor[n->in[i]->id].needs_grad && !differentiable(n->op))
                return lt_error(LT_EINVAL, "%s%s%s%s: the loss depends on what it reads, and it has no backward; give "
                                "it one, or lt_detach what is to learn nothing%s", n->op->name, *n->name ? " \"" : "",
                                n->name, *n->name ? "\"" : "", lt_where(n->file, n->line, where));
            if (n->in[i] && p->tensor[n->in[i]->id].needs_grad && check_reader(p, n, i))
                return LT_EINVAL;
            if (n->in[i])
                reaches[n->in[i]->id] = true;
        }
    }
    return LT_OK;
}

static bool gradient_arrives(const lt_plan *p, const lt_node *n)
{
    for (int i = 0; i < n->n_out; i++)
        if (p->tensor[n->outs[i]->id].needs_grad && plan_root(p, n->outs[i])->touched)
            return true;
    return false;
}

/* Nothing does where the loss depends on nothing that learns. */
static void touch_loss(lt_plan *p)
{
    plan_root(p, p->loss)->touched = p->tensor[p->loss->id].needs_grad;
}

/* Walk backward once without writing steps: which nodes take part, and what values they will read. */
static void find_what_is_read(lt_plan *p)
{
    touch_loss(p);
    for (int k = p->g->n_nodes - 1; k >= 0; k--) {
        const lt_node *n = p->g->node[k];

        if (!n || lt_op_is_view(n->op) || !differentiable(n->op) || !gradient_arrives(p, n))
            continue;
        p->node[k].active = true;
        for (int i = 0; i < n->n_in; i++) {
            if (!n->in[i])
                continue;
            plan_root(p, n->in[i])->needed |= plan_keeps_in(n->op, i);
            if (p->tensor[n->in[i]->id].needs_grad)
                plan_root(p, n->in[i])->touched = true;
        }
        for (int i = 0; i < n->n_out; i++)
            plan_root(p, n->outs[i])->needed |= plan_keeps_out(n->op, i);
    }
    for (int i = 0; i < p->g->n_tensors; i++)
        p->tensor[i].touched = false;
}

static bool inputs_at_hand(const lt_plan *p, const lt_node *n)
{
    for (int i = 0; i < n->n_in; i++)
        if (n->in[i] && plan_root_tensor(p, n->in[i])->node && !plan_root(p, n->in[i])->at_hand)
            return false;
    return true;
}

/* A cheap op whose inputs will be there in the backward pass, kept or made again, is made again itself. */
static void choose_what_to_redo(lt_plan *p)
{
    for (int k = 0; k < p->g->n_nodes; k++) {
        const lt_node *n = p->g->node[k];
        bool can;

        if (!n || lt_op_is_view(n->op))
            continue;
        can = (n->op->flags & LT_OP_CHEAP) && n->n_out == 1 && inputs_at_hand(p, n);
        for (int i = 0; i < n->n_out; i++) {
            plan_tensor *out = &p->tensor[n->outs[i]->id];

            out->at_hand = out->needed || can;
            out->redo = can && !n->outs[i]->is_output;
        }
    }
}

/* Write the steps that make root t again, inputs first. */
static bool redo(lt_plan *p, int t)
{
    plan_tensor *info = &p->tensor[t];
    lt_node *n = p->g->tensor[t]->node;

    if (!info->redo || info->redone)
        return true;
    for (int i = 0; i < n->n_in; i++)
        if (n->in[i] && !redo(p, p->tensor[n->in[i]->id].root))
            return false;
    info->redone = true;
    return plan_add_step(p, STEP_RECOMPUTE, n) != NULL;
}

static bool redo_what_is_read(lt_plan *p, const lt_node *n)
{
    bool ok = true;

    for (int i = 0; ok && i < n->n_in; i++)
        if (n->in[i] && plan_keeps_in(n->op, i))
            ok = redo(p, p->tensor[n->in[i]->id].root);
    for (int i = 0; ok && i < n->n_out; i++)
        if (plan_keeps_out(n->op, i))
            ok = redo(p, p->tensor[n->outs[i]->id].root);
    return ok;
}

static bool reads_twice(const lt_plan *p, const lt_node *n, int i)
{
    for (int j = 0; j < n->n_in; j++)
        if (j != i && n->in[j] && plan_root(p, n->in[j]) == plan_root(p, n->in[i]))
            return true;
    return false;
}

/* A view of part of the way (a reshape) shares its root's gradient, so the root decides what is fresh. */
static bool start_gradients(lt_plan *p, const lt_node *n, bool *fresh)
{
    for (int i = 0; i < n->n_in; i++) {
        const lt_tensor *t = n->in[i];

        if (!t || !p->tensor[t->id].needs_grad || plan_root(p, t)->touched)
            continue;
        if (plan_root_tensor(p, t)->param && !p->replace_grads)
            continue;
        plan_root(p, t)->touched = true;
        if ((n->op->flags & LT_OP_ASSIGNS) && !reads_twice(p, n, i)) {
            fresh[i] = true;
        } else {
            plan_step *zero = plan_add_step(p, STEP_ZERO, NULL);

            if (!zero)
                return false;
            zero->zero = p->tensor[t->id].root;
        }
    }
    return true;
}

/* NULL without memory */
static lt_real *new_gradient(lt_plan *p, lt_param *param)
{
    if (!p->later_part)
        return lt_param_need_grad(param) ? param->grad : NULL;
    p->fixed_bytes += (size_t)lt_param_numel(param) * sizeof(lt_real);
    return lt_arena_array(p->arena, (size_t)lt_param_numel(param), sizeof(lt_real));
}

static bool give_params_gradients(lt_plan *p, const lt_node *n)
{
    for (int i = 0; i < n->n_in; i++) {
        lt_param *param = n->in[i] ? plan_root_tensor(p, n->in[i])->param : NULL;
        lt_real **grad = param ? &plan_root(p, n->in[i])->param_grad : NULL;

        if (!param || !p->tensor[n->in[i]->id].needs_grad)
            continue;
        param->uses = *grad ? param->uses + 1 : 1;
        if (*grad)
            continue;
        *grad = new_gradient(p, param);
        if (!*grad)
            return false;
    }
    return true;
}

static bool add_backward(lt_plan *p, lt_node *n)
{
    bool fresh[LT_MAX_IN] = { false };
    plan_step *s;

    if (!redo_what_is_read(p, n) || !start_gradients(p, n, fresh) || !give_params_gradients(p, n))
        return false;
    s = plan_add_step(p, STEP_BACKWARD, n);
    if (s)
        for (int i = 0; i < LT_MAX_IN; i++)
            s->fresh[i] = fresh[i];
    return s != NULL;
}

lt_status plan_autodiff(lt_plan *p, bool recompute)
{
    lt_status st;

    find_who_needs_grad(p);
    st = check_backward(p);
    if (st)
        return st;
    find_what_is_read(p);
    if (recompute)
        choose_what_to_redo(p);
    touch_loss(p);
    for (int k = p->g->n_nodes - 1; k >= 0; k--)
        if (p->node[k].active && !add_backward(p, p->g->node[k]))
            return lt_error(LT_ENOMEM, "no memory to compile the backward pass");
    return LT_OK;
}
