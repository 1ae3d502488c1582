/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/graph/int8.h"

#include "libtensor/graph/plan_internal.h"

#include <assert.h>
#include <string.h>

const lt_int8_range *lt_int8_find(const lt_int8_table *table, const char *layer)
{
    for (int i = 0; table && i < table->n; i++)
        if (strcmp(table->layer[i].layer, layer) == 0)
            return &table->layer[i].range;
    return NULL;
}

/* Whatever its sizes are */
static bool might_take(const lt_node *n)
{
    return *n->name && n->op->takes_int8 && !n->outs[0]->is_output;
}

bool lt_int8_takes(const lt_node *n)
{
    return might_take(n) && n->op->takes_int8(n);
}

void lt_plan_observe(lt_plan *p, lt_observer see, void *ctx)
{
    assert(!p->train);
    for (int i = 0; i < p->n_steps; i++) {
        const lt_call *c = &p->step[i].call;

        plan_run_step(p, &p->step[i]);
        if (lt_int8_takes(c->node))
            see(ctx, c->node->name, c->in[0]->data, lt_numel(c->in[0]));
    }
}

/* The step as the other plan has it, on this one's inputs. */
static void run_beside(const plan_step *exact, const plan_step *rounded)
{
    lt_call c = rounded->call;

    for (int i = 0; i < c.n_in; i++)
        if (c.in[i] && !lt_is_constant(c.in[i]))
            c.in[i] = exact->call.in[i];
    c.node->op->forward(&c);
}

void lt_plan_compare(lt_plan *exact, lt_plan *rounded, const lt_int8_table *table, lt_comparer see, void *ctx)
{
    assert(!exact->train && exact->n_steps == rounded->n_steps);
    for (int i = 0; i < exact->n_steps; i++) {
        const plan_step *e = &exact->step[i], *r = &rounded->step[i];

        plan_run_step(exact, &exact->step[i]);
        if (!might_take(e->node) || !lt_int8_find(table, e->node->name))
            continue;
        run_beside(e, r);
        see(ctx, e->node->name, e->call.out->data, r->call.out->data, lt_numel(e->call.out));
    }
}
