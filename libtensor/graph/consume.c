/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parameters that an inference plan holds in another form need not stay in memory beside it: each is given back
 * after the step of the prologue that reads it last, so that never all of both forms are there.
 */
#include "libtensor/base/arena.h"
#include "libtensor/graph/plan_internal.h"

static const lt_param *param_of(const lt_plan *p, const lt_tensor *t)
{
    return t ? plan_root_tensor(p, t)->param : NULL;
}

static bool reads(const lt_plan *p, const plan_step *s, const lt_param *param)
{
    for (int i = 0; i < s->node->n_in; i++)
        if (param_of(p, s->node->in[i]) == param)
            return true;
    return false;
}

static bool is_output(const lt_plan *p, const lt_param *param)
{
    for (int i = 0; i < p->g->n_tensors; i++)
        if (p->g->tensor[i]->is_output && param_of(p, p->g->tensor[i]) == param)
            return true;
    return false;
}

static bool read_after(const lt_plan *p, int step, const lt_param *param)
{
    for (int i = step + 1; i < p->n_prologue; i++)
        if (reads(p, &p->prologue[i], param))
            return true;
    for (int i = 0; i < p->n_steps; i++)
        if (reads(p, &p->step[i], param))
            return true;
    return is_output(p, param);
}

void plan_consume(lt_plan *p)
{
    for (int i = 0; i < p->n_prologue; i++) {
        const lt_node *n = p->prologue[i].node;

        n->op->forward(&p->prologue[i].call);
        for (int k = 0; k < n->n_in; k++) {
            const lt_param *param = param_of(p, n->in[k]);

            if (param && !read_after(p, i, param))
                lt_discard(param->data, (size_t)lt_param_numel(param) * sizeof(lt_real));
        }
    }
    p->n_prologue = 0;
}
