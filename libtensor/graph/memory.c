/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Memory planning: every value, gradient, saved and work buffer lives from its first step to its last,
 * and buffers whose lives do not overlap share memory.
 */
#include "libtensor/graph/plan_internal.h"

#include <stdlib.h>

/* ---- buffers and their lives ---------------------------------------------------------------------- */

static int buffer_new(lt_plan *p, size_t bytes)
{
    plan_buffer *list = lt_arena_grow(p->arena, p->buffer, (size_t)p->n_buffers, &p->buffers_room, sizeof(*list));

    if (!list)
        return -1;
    p->buffer = list;
    bytes = (bytes + LT_ALIGN - 1) & ~(size_t)(LT_ALIGN - 1);
    p->buffer[p->n_buffers] = (plan_buffer){ .bytes = bytes ? bytes : LT_ALIGN, .first = -1, .same_as = -1 };
    return p->n_buffers++;
}

/* Make the buffer at its first use, and stretch its life to this step. */
static bool use(lt_plan *p, int *buffer, size_t bytes, int step)
{
    if (*buffer < 0)
        *buffer = buffer_new(p, bytes);
    if (*buffer < 0)
        return false;
    if (p->buffer[*buffer].first < 0)
        p->buffer[*buffer].first = step;
    p->buffer[*buffer].last = (int)lt_max_i64(step, p->buffer[*buffer].last);
    return true;
}

/* Inputs and results live in our memory; parameters and constants bring their own, and so do results of
 * the prologue, which must outlast every run. */
static bool ours(const lt_plan *p, const lt_tensor *root)
{
    return root->kind == LT_INPUT || (root->kind == LT_RESULT && !p->node[root->node->id].constant);
}

static bool use_value(lt_plan *p, const lt_tensor *t, int step)
{
    const lt_tensor *root = plan_root_tensor(p, t);

    return !ours(p, root) || use(p, &plan_root(p, t)->value, lt_nbytes(root), step);
}

/* A value as the backward pass reads it: kept, or made again. */
static bool use_backward(lt_plan *p, const lt_tensor *t, int step)
{
    plan_tensor *info = plan_root(p, t);

    return info->redo ? use(p, &info->again, lt_nbytes(plan_root_tensor(p, t)), step) : use_value(p, t, step);
}

static bool use_grad(lt_plan *p, const lt_tensor *t, int step)
{
    const lt_tensor *root = plan_root_tensor(p, t);

    return root->param || !p->tensor[t->id].needs_grad
        || use(p, &plan_root(p, t)->grad, (size_t)lt_numel(root) * sizeof(lt_real), step);
}

static bool use_saved(lt_plan *p, plan_node *n, int step)
{
    bool ok = true;

    for (int i = 0; i < LT_MAX_SAVED; i++)
        if (n->saved_bytes[i])
            ok = ok && use(p, &n->saved[i], n->saved_bytes[i], step);
    return ok;
}

/* What a part of a batch has shared others read until all meet again: a faster one may not put anything else there in
 * the meantime. */
static bool use_shared(lt_plan *p, plan_node *n, int step)
{
    return use_saved(p, n, step) && (!plan_share_of(p, step) || use_saved(p, n, plan_next_share(p, step + 1)));
}

static bool live_forward(lt_plan *p, const lt_node *n, int step)
{
    bool ok = use_shared(p, &p->node[n->id], step);

    for (int i = 0; i < n->n_in; i++)
        ok = ok && (!n->in[i] || use_value(p, n->in[i], step));
    for (int i = 0; i < n->n_out; i++)
        ok = ok && use_value(p, n->outs[i], step);
    return ok;
}

static bool live_recompute(lt_plan *p, const lt_node *n, int step)
{
    bool ok = use_saved(p, &p->node[n->id], step);

    for (int i = 0; i < n->n_in; i++)
        ok = ok && (!n->in[i] || use_backward(p, n->in[i], step));
    return ok && use_backward(p, n->outs[0], step);
}

static bool live_backward(lt_plan *p, const lt_node *n, int step)
{
    bool ok = use_shared(p, &p->node[n->id], step);

    for (int i = 0; i < n->n_in; i++) {
        if (!n->in[i])
            continue;
        ok = ok && (!plan_keeps_in(n->op, i) || use_backward(p, n->in[i], step));
        ok = ok && use_grad(p, n->in[i], step);
    }
    for (int i = 0; i < n->n_out; i++) {
        ok = ok && (!plan_keeps_out(n->op, i) || use_backward(p, n->outs[i], step));
        ok = ok && (plan_root(p, n->outs[i])->grad < 0 || use_grad(p, n->outs[i], step));
    }
    return ok;
}

static bool live_step(lt_plan *p, int i)
{
    const plan_step *s = &p->step[i];

    switch (s->kind) {
    case STEP_FORWARD:
        return live_forward(p, s->node, i);
    case STEP_RECOMPUTE:
        return live_recompute(p, s->node, i);
    case STEP_BACKWARD:
        return live_backward(p, s->node, i);
    case STEP_ZERO:
        return use_grad(p, p->g->tensor[s->zero], i);
    }
    return false;
}

/* Inputs, outputs and asked-for gradients stay after the last step. */
static bool live_forever(lt_plan *p)
{
    bool ok = true;

    for (int i = 0; ok && i < p->g->n_tensors; i++) {
        const lt_tensor *t = p->g->tensor[i];

        if (t->kind == LT_INPUT || (t->is_output && plan_root(p, t)->value >= 0))
            ok = use_value(p, t, p->n_steps);
        if (t->kind == LT_INPUT && t->wants_grad && p->tensor[i].grad >= 0)
            ok = ok && use_grad(p, t, p->n_steps);
    }
    return ok;
}

static bool find_lives(lt_plan *p)
{
    bool ok = true;

    for (int i = 0; i < p->g->n_tensors; i++)           /* before step 0, so that nothing overwrites it */
        if (p->g->tensor[i]->kind == LT_INPUT)
            ok = ok && use_value(p, p->g->tensor[i], 0);
    for (int i = 0; ok && i < p->n_steps; i++) {
        if (i == p->n_forward && p->train)
            ok = use_grad(p, p->loss, i);
        ok = ok && live_step(p, i);
    }
    return ok && live_forever(p);
}

/* ---- sharing -------------------------------------------------------------------------------------- */

static plan_buffer *owner(const lt_plan *p, int buffer)
{
    while (p->buffer[buffer].same_as >= 0)
        buffer = p->buffer[buffer].same_as;
    return &p->buffer[buffer];
}

/* Step i makes `made` of `used`: in the same memory, if that one dies there. */
static void share(lt_plan *p, int used, int made, int i)
{
    if (used < 0 || made < 0 || owner(p, used)->last != i || p->buffer[made].first != i
        || owner(p, used)->bytes != p->buffer[made].bytes)
        return;
    owner(p, used)->last = p->buffer[made].last;
    p->buffer[made].same_as = used;
    p->buffer[used].replaced = true;
}

/* An in-place op's output may stand where its input was, and a fresh gradient of the input where that of the output. */
static void share_in_place(lt_plan *p)
{
    for (int i = 0; i < p->n_steps; i++) {
        const plan_step *s = &p->step[i];
        const lt_node *n = s->node;

        if (!n || !n->in[0])
            continue;
        if (s->kind == STEP_FORWARD && (n->op->flags & LT_OP_INPLACE))
            share(p, plan_root(p, n->in[0])->value, plan_root(p, n->outs[0])->value, i);
        else if (s->kind == STEP_BACKWARD && (n->op->flags & LT_OP_INPLACE_GRAD) && s->fresh[0])
            share(p, plan_root(p, n->outs[0])->grad, plan_root(p, n->in[0])->grad, i);
    }
}

/* A piece lives in the whole of which it is one, from the element at, as long as nothing is made in place of either. */
static void share_piece(lt_plan *p, const lt_tensor *piece, const lt_tensor *whole, int64_t at)
{
    const int inner = plan_root(p, piece)->value, outer = plan_root(p, whole)->value;
    const size_t shift = (size_t)at * sizeof(lt_real);
    plan_buffer *b, *o;

    if (at < 0 || inner < 0 || outer < 0)
        return;
    b = &p->buffer[inner];
    if (b->same_as >= 0 || b->replaced || p->buffer[outer].replaced || shift % LT_ALIGN
        || lt_nbytes(piece) % LT_ALIGN)
        return;
    o = owner(p, outer);
    if (o == b)
        return;
    o->first = (int)lt_min_i64(o->first, b->first);
    o->last = (int)lt_max_i64(o->last, b->last);
    b->same_as = outer;
    b->shift = shift;
}

/* What is put together, or cut out, need not be moved then. */
static void share_pieces(lt_plan *p)
{
    for (int k = 0; k < p->n_steps; k++) {
        const lt_node *n = p->step[k].node;

        for (int i = 0; n->op->in_piece && i < n->n_in; i++)
            share_piece(p, n->in[i], n->outs[0], n->op->in_piece(n, i));
        if (n->op->out_piece)
            share_piece(p, n->outs[0], n->in[0], n->op->out_piece(n));
    }
}

static int by_size(const void *a, const void *b)
{
    const plan_buffer *x = *(plan_buffer *const *)a, *y = *(plan_buffer *const *)b;

    if (x->bytes != y->bytes)
        return x->bytes < y->bytes ? 1 : -1;
    return x->first != y->first ? x->first - y->first : (x > y) - (x < y);
}

static int by_offset(const void *a, const void *b)
{
    const plan_buffer *x = *(plan_buffer *const *)a, *y = *(plan_buffer *const *)b;

    return (x->offset > y->offset) - (x->offset < y->offset);
}

/* The tightest gap between the placed buffers that live at the same time; behind them all if none fits. */
static size_t find_gap(plan_buffer *const *alive, int n, size_t bytes)
{
    size_t end = 0, best = SIZE_MAX, best_waste = SIZE_MAX;

    for (int i = 0; i < n; i++) {
        if (alive[i]->offset >= end + bytes && alive[i]->offset - end - bytes < best_waste) {
            best = end;
            best_waste = alive[i]->offset - end - bytes;
        }
        if (alive[i]->offset + alive[i]->bytes > end)
            end = alive[i]->offset + alive[i]->bytes;
    }
    return best == SIZE_MAX ? end : best;
}

/* Greedy by size: the big ones choose first. */
static bool place(lt_plan *p)
{
    plan_buffer **order = lt_arena_array(p->arena, (size_t)p->n_buffers + 1, sizeof(*order));
    plan_buffer **alive = lt_arena_array(p->arena, (size_t)p->n_buffers + 1, sizeof(*alive));
    int n = 0;

    if (!order || !alive)
        return false;
    for (int i = 0; i < p->n_buffers; i++)
        if (p->buffer[i].same_as < 0)
            order[n++] = &p->buffer[i];
    qsort(order, (size_t)n, sizeof(*order), by_size);
    for (int i = 0; i < n; i++) {
        int n_alive = 0;

        for (int j = 0; j < i; j++)
            if (order[j]->first <= order[i]->last && order[i]->first <= order[j]->last)
                alive[n_alive++] = order[j];
        qsort(alive, (size_t)n_alive, sizeof(*alive), by_offset);
        order[i]->offset = find_gap(alive, n_alive, order[i]->bytes);
        if (order[i]->offset + order[i]->bytes > p->memory_bytes)
            p->memory_bytes = order[i]->offset + order[i]->bytes;
    }
    return true;
}

/* ---- binding -------------------------------------------------------------------------------------- */

static void *at(const lt_plan *p, int buffer)
{
    size_t shift = 0;

    if (buffer < 0)
        return NULL;
    for (int b = buffer; b >= 0; b = p->buffer[b].same_as)
        shift += p->buffer[b].shift;
    return p->memory + owner(p, buffer)->offset + shift;
}

static void *value_of(const lt_plan *p, const lt_tensor *t)
{
    const lt_tensor *root = plan_root_tensor(p, t);

    if (root->kind == LT_PARAM)
        return root->param->data;
    if (root->kind == LT_CONSTANT || plan_root(p, t)->value < 0)
        return root->data;                      /* a constant, or made by the prologue */
    return at(p, plan_root(p, t)->value);
}

lt_real *plan_grad(const lt_plan *p, const lt_tensor *t)
{
    const lt_tensor *root = plan_root_tensor(p, t);

    if (!p->tensor[t->id].needs_grad)
        return NULL;
    return root->param ? plan_root(p, t)->param_grad : at(p, plan_root(p, t)->grad);
}

/* Forward calls see the tensors themselves; backward calls see copies of those that are made again. */
static bool bind_tensors(lt_plan *p)
{
    for (int i = 0; i < p->g->n_tensors; i++) {
        lt_tensor *t = p->g->tensor[i];
        const plan_tensor *root = plan_root(p, t);

        t->data = value_of(p, t);
        p->tensor[i].moves = t->param ? lt_rows_moves(t->param) : 0;
        p->tensor[i].backward_view = t;
        if (root->again < 0)
            continue;
        p->tensor[i].backward_view = lt_arena_alloc(p->arena, sizeof(*t));
        if (!p->tensor[i].backward_view)
            return false;
        *p->tensor[i].backward_view = *t;
        p->tensor[i].backward_view->data = at(p, root->again);
    }
    return true;
}

static void bind_common(lt_plan *p, plan_step *s)
{
    const plan_node *info = &p->node[s->node->id];

    lt_call_init(&s->call, s->node);
    s->call.train = p->train && info->active;
    s->call.goes_back = p->train;
    for (int i = 0; i < LT_MAX_SAVED; i++) {
        s->call.saved[i] = at(p, info->saved[i]);
        s->call.saved_bytes[i] = info->saved_bytes[i];
    }
    s->call.work_bytes = info->work_bytes;
}

static void bind_backward_values(lt_plan *p, plan_step *s)
{
    lt_call *c = &s->call;

    for (int i = 0; i < c->n_in; i++)
        if (c->in[i])
            c->in[i] = p->tensor[c->in[i]->id].backward_view;
    for (int i = 0; i < c->n_out; i++)
        c->outs[i] = p->tensor[c->outs[i]->id].backward_view;
    c->out = c->outs[0];
}

static void bind_gradients(lt_plan *p, plan_step *s)
{
    lt_call *c = &s->call;

    for (int i = 0; i < c->n_in; i++) {
        c->din[i] = c->in[i] ? plan_grad(p, c->in[i]) : NULL;
        c->fresh[i] = s->fresh[i];
    }
    for (int i = 0; i < c->n_out; i++)
        c->douts[i] = plan_root(p, c->outs[i])->grad < 0 ? NULL : plan_grad(p, c->outs[i]);
    c->dout = c->douts[0];
}

static void bind_step(lt_plan *p, plan_step *s)
{
    if (s->kind == STEP_ZERO) {
        const lt_tensor *root = p->g->tensor[s->zero];

        s->zero_data = plan_grad(p, root);
        s->zero_bytes = (size_t)lt_numel(root) * sizeof(lt_real);
        s->zero_rows = root->param && root->param->rows ? root->param : NULL;
        return;
    }
    bind_common(p, s);
    if (s->kind != STEP_FORWARD)
        bind_backward_values(p, s);
    if (s->kind == STEP_BACKWARD)
        bind_gradients(p, s);
}

/* ---- what lasts as long as the plan ---------------------------------------------------------------- */

/* Places the results of the prologue one after the other from `at` on, or with NULL only measures: bytes. */
static size_t place_constants(lt_plan *p, char *at)
{
    size_t bytes = 0;

    for (int i = 0; i < p->n_prologue; i++)
        for (int k = 0; k < p->prologue[i].node->n_out; k++) {
            lt_tensor *t = p->prologue[i].node->outs[k];

            if (p->tensor[t->id].root != t->id)
                continue;
            if (at)
                t->data = at + bytes;
            bytes += (lt_nbytes(t) + LT_ALIGN - 1) & ~(size_t)(LT_ALIGN - 1);
        }
    return bytes;
}

/* They stay between runs, and stand in one block: most of it is weights, which are then in huge pages. */
static bool allocate_constants(lt_plan *p)
{
    const size_t bytes = place_constants(p, NULL);
    char *all = lt_arena_alloc(p->arena, bytes);

    p->fixed_bytes += bytes;
    if (all)
        place_constants(p, all);
    return all;
}

/* One scratch area serves all steps: they run one after another. */
static bool allocate_work(lt_plan *p)
{
    size_t most = 0;
    void *work;

    for (int k = 0; k < p->g->n_nodes; k++)
        most = p->node[k].work_bytes > most ? p->node[k].work_bytes : most;
    work = lt_arena_alloc(p->arena, most);
    if (!work)
        return false;
    p->fixed_bytes += most;
    for (int i = 0; i < p->n_steps; i++)
        p->step[i].call.work = work;
    for (int i = 0; i < p->n_prologue; i++)
        p->prologue[i].call.work = work;
    return true;
}

lt_status plan_memory(lt_plan *p)
{
    if (!find_lives(p))
        goto no_memory;
    share_in_place(p);
    if (!p->train)
        share_pieces(p);
    if (!place(p) || !allocate_constants(p))
        goto no_memory;
    p->memory = lt_alloc(p->memory_bytes);
    if (!p->memory || !bind_tensors(p))
        goto no_memory;
    for (int i = 0; i < p->n_prologue; i++)
        bind_step(p, &p->prologue[i]);
    for (int i = 0; i < p->n_steps; i++)
        bind_step(p, &p->step[i]);
    if (!allocate_work(p))
        goto no_memory;
    if (p->train)
        p->loss_grad = plan_grad(p, p->loss);
    return LT_OK;
no_memory:
    return lt_error(LT_ENOMEM, "no memory for a plan of %zu MB", p->memory_bytes >> 20);
}
