/* SPDX-License-Identifier: Apache-2.0 */
/* The steps of a plan: listed, and one of them run. */
#include "libtensor/base/clock.h"
#include "libtensor/base/parallel.h"
#include "libtensor/graph/plan_internal.h"

#include <string.h>

plan_step *plan_add_step(lt_plan *p, step_kind kind, lt_node *node)
{
    plan_step *list = lt_arena_grow(p->arena, p->step, (size_t)p->n_steps, &p->steps_room, sizeof(*list));

    if (!list)
        return NULL;
    p->step = list;
    p->step[p->n_steps] = (plan_step){ .kind = kind, .node = node };
    return &p->step[p->n_steps++];
}

/* of a gradient, which a task adds */

plan_share_fn plan_share_of(const lt_plan *p, int step)
{
    const plan_step *s = &p->step[step];

    if (!p->train || !s->node || !p->node[s->node->id].active)
        return NULL;
    if (s->kind == STEP_FORWARD)
        return s->node->op->forward_share;
    return s->kind == STEP_BACKWARD ? s->node->op->backward_share : NULL;
}

int plan_next_share(const lt_plan *p, int from)
{
    while (from < p->n_steps && !plan_share_of(p, from))
        from++;
    return from;
}

/* ---- running one ---------------------------------------------------------------------------------- */

enum { ZERO_BYTES = 1 << 18 };          /* of a task */

static void zero_task(void *ctx, int64_t i)
{
    const plan_step *s = ctx;
    const size_t at = (size_t)i * ZERO_BYTES, left = s->zero_bytes - at;

    memset((char *)s->zero_data + at, 0, left < ZERO_BYTES ? left : ZERO_BYTES);
}

void plan_run_step(lt_plan *p, plan_step *s)
{
    const lt_op *op = s->node ? s->node->op : NULL;

    if (op && (op->flags & LT_OP_RANDOM))
        s->call.rng = lt_rng_make(p->seed, lt_rng_mix(p->run, (uint64_t)s->node->id));
    switch (s->kind) {
    case STEP_FORWARD:
        op->forward(&s->call);
        break;
    case STEP_RECOMPUTE:
        (op->recompute ? op->recompute : op->forward)(&s->call);
        break;
    case STEP_ZERO:
        if (s->zero_rows)
            lt_rows_clear(s->zero_rows, s->zero_data);
        else
            lt_parallel_for(lt_ceil_div((int64_t)s->zero_bytes, ZERO_BYTES), zero_task, s);
        break;
    case STEP_BACKWARD:
        op->backward(&s->call);
        break;
    }
}

static void run_timed(lt_plan *p, plan_step *s)
{
    const double start = lt_clock();

    plan_run_step(p, s);
    s->seconds += lt_clock() - start;
}

static void start_backward(lt_plan *p, int step)
{
    if (step == p->n_forward && p->loss_grad)
        *p->loss_grad = (lt_real)p->loss_weight;
}

void plan_run_at(lt_plan *p, int step)
{
    start_backward(p, step);
    if (p->profile)
        run_timed(p, &p->step[step]);
    else
        plan_run_step(p, &p->step[step]);
}
