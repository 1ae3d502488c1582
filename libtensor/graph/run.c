/* SPDX-License-Identifier: Apache-2.0 */
/* All steps of a plan, one after another; and which of them first makes a number that is none. */
#include "libtensor/base/cpu.h"
#include "libtensor/graph/plan_internal.h"

#include <math.h>
#include <stdio.h>

static void run_all(lt_plan *p)
{
    if (p->n_parts > 1) {
        plan_run_parts(p);
        return;
    }
    for (int i = 0; i < p->n_steps; i++)
        plan_run_at(p, i);
}

/* Is each parameter where it was when the plan was compiled? */
static lt_status check_params(lt_plan *p)
{
    bool moved = false;

    for (int k = 0; k < p->n_sets; k++)
        moved |= p->set[k].moves != lt_params_moves(p->set[k].set);
    for (int i = 0; moved && i < p->g->n_tensors; i++) {
        const lt_tensor *t = p->g->tensor[i];

        if (t->param && p->tensor[i].moves != lt_rows_moves(t->param))
            return lt_error(LT_EINVAL, "\"%s\" has been resized since the plan was compiled; record the graph and "
                            "compile it again", t->name);
    }
    for (int k = 0; moved && k < p->n_sets; k++)
        p->set[k].moves = lt_params_moves(p->set[k].set);
    return LT_OK;
}

static void refresh(lt_plan *p)
{
    for (int k = 0; k < p->n_sets; k++)
        p->set[k].version = lt_params_version(p->set[k].set);
    for (int k = 0; k < p->n_parts; k++) {
        lt_plan *part = p->part[k];

        for (int i = 0; i < part->n_prologue; i++)
            plan_run_step(part, &part->prologue[i]);
    }
}

void lt_plan_refresh(lt_plan *p)
{
    if (check_params(p) == LT_OK)
        refresh(p);
}

static bool params_have_changed(const lt_plan *p)
{
    for (int k = 0; k < p->n_sets; k++)
        if (p->set[k].version != lt_params_version(p->set[k].set))
            return true;
    return false;
}

/* What statistics collect in a run of a training plan */
static void note_batch(lt_plan *p)
{
    for (int k = 0; p->train && k < p->n_sets; k++)
        lt_params_collect(p->set[k].set, p->replace_grads);
}

/* Subnormal numbers are zero in tasks; so they are between them, as which work is a task depends on the threads. */
lt_status lt_run(lt_plan *p)
{
    const lt_status st = check_params(p);
    unsigned mode;

    if (st)
        return st;
    mode = lt_flush_denormals();
    if (!p->train && params_have_changed(p))
        refresh(p);
    run_all(p);
    note_batch(p);
    lt_restore_denormals(mode);
    return LT_OK;
}

static bool all_finite(const lt_real *x, int64_t n)
{
    for (int64_t i = 0; i < n; i++)
        if (!isfinite(x[i]))
            return false;
    return true;
}

/* Of a parameter that is stepped by rows only the touched ones have a gradient. */
static bool gradient_is_finite(const lt_tensor *t, const lt_real *grad)
{
    const int64_t width = t->param && t->param->rows ? lt_param_width(t->param) : 0;
    const lt_row_range *range;
    int n;

    if (!width)
        return all_finite(grad, lt_numel(t));
    range = lt_param_touched(t->param, &n);
    for (int i = 0; i < n; i++)
        if (!all_finite(grad + range[i].first * width, range[i].n * width))
            return false;
    return true;
}

static bool step_is_finite(const plan_step *s)
{
    const lt_call *c = &s->call;

    if (s->kind == STEP_ZERO)
        return true;
    for (int i = 0; s->kind != STEP_BACKWARD && i < c->n_out; i++)
        if (c->outs[i]->dtype == LT_F32 && !all_finite(c->outs[i]->data, lt_numel(c->outs[i])))
            return false;
    for (int i = 0; s->kind == STEP_BACKWARD && i < c->n_in; i++)
        if (c->din[i] && !gradient_is_finite(c->in[i], c->din[i]))
            return false;
    return true;
}

static bool parts_are_finite(const lt_plan *first, int step)
{
    for (int k = 0; k < first->n_parts; k++)
        if (!step_is_finite(&first->part[k]->step[step]))
            return false;
    return true;
}

/* Of the last step up to i that has a name: an op without parameters has none, but follows one that has. */
static const char *name_before(const lt_plan *p, int i)
{
    while (i > 0 && (!p->step[i].node || !*p->step[i].node->name))
        i--;
    return p->step[i].node ? p->step[i].node->name : "";
}

void lt_plan_find_nonfinite(lt_plan *p, char *where, size_t bytes)
{
    if (bytes)
        *where = '\0';
    if (check_params(p))
        return;
    note_batch(p);
    for (int i = 0; i < p->n_steps; i++) {
        const plan_step *s = &p->step[i];

        plan_run_parts_at(p, i);
        if (parts_are_finite(p, i))
            continue;
        snprintf(where, bytes, "%s %s\"%s\"%s", s->node->op->name, *s->node->name ? "" : "after ", name_before(p, i),
                 s->kind == STEP_BACKWARD ? " (gradient)" : "");
        return;
    }
}
