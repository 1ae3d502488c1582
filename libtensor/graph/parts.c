/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A batch in parts, each with a plan of its own, all alike. They run in step: where a batch norm needs to know the
 * whole batch, each part first measures its own images, and goes on when all have done so.
 *
 * A part a thread, its layers are not spread over threads: nothing waits for another core but at those places, and a
 * core finds in its own cache what it has made. With more threads than parts these run one after another instead, each
 * layer on all threads. The bits are the same.
 */
#include "libtensor/base/parallel.h"
#include "libtensor/graph/plan_internal.h"

enum { PIECE = 1 << 15 };           

/* ---- joining ---- */

static bool join_step(lt_plan *first, int i)
{
    const int n = first->n_parts;
    lt_call **call = lt_arena_array(first->arena, (size_t)n, sizeof(lt_call *));

    if (!call)
        return false;
    for (int k = 0; k < n; k++) {
        lt_call *c = &first->part[k]->step[i].call;

        call[k] = c;
        c->part = call;
        c->n_parts = n;
    }
    return true;
}

lt_status plan_join_parts(lt_plan *first)
{
    for (int i = 0; i < first->n_steps; i++)
        if (plan_share_of(first, i) && !join_step(first, i))
            return lt_error(LT_ENOMEM, "no memory for %d parts of a plan", first->n_parts);
    return LT_OK;
}

/* ---- running ---- */

/* Steps [begin, end) of all parts, then what the op of `end` shares. */
typedef struct {
    lt_plan *first;
    int begin, end;
} stretch;

static void run_stretch(void *ctx, int64_t k)
{
    const stretch *s = ctx;
    lt_plan *p = s->first->part[k];

    for (int i = s->begin; i < s->end; i++)
        plan_run_at(p, i);
    if (s->end < p->n_steps)
        plan_share_of(p, s->end)(&p->step[s->end].call);
}

bool plan_parts_abreast(const lt_plan *first)
{
    return lt_threads() <= first->n_parts;
}

static void run_all(stretch *s)
{
    if (plan_parts_abreast(s->first)) {
        lt_parallel_for(s->first->n_parts, run_stretch, s);
        return;
    }
    for (int k = 0; k < s->first->n_parts; k++)
        run_stretch(s, k);
}

typedef struct { lt_real *to, *from; int64_t n; } addition;

static void add_piece(void *ctx, int64_t i)
{
    const addition *a = ctx;
    const int64_t at = i * PIECE;

    lt_k->add_to(a->to + at, a->from + at, (size_t)lt_min_i64(PIECE, a->n - at));
}

/* n elements from `at` on of the gradient of tensor t */
static void add_parts(lt_plan *first, int t, int64_t at, int64_t n)
{
    addition a = { .to = first->tensor[t].param_grad + at, .n = n };

    for (int k = 1; k < first->n_parts; k++) {
        a.from = first->part[k]->tensor[t].param_grad + at;
        lt_parallel_for(lt_ceil_div(a.n, PIECE), add_piece, &a);
    }
}

/* The gradients of the later parts are added to the first one's, in order; of a parameter that is stepped by rows,
 * those of the touched ones. */
static void add_gradients(lt_plan *first)
{
    for (int t = 0; t < first->g->n_tensors; t++) {
        const lt_param *p = first->g->tensor[t]->param;
        const lt_row_range *range;
        int n = 0;

        if (!first->tensor[t].param_grad)
            continue;
        if (!p || !p->rows) {
            add_parts(first, t, 0, lt_numel(first->g->tensor[t]));
            continue;
        }
        range = lt_param_touched(p, &n);
        for (int i = 0; i < n; i++)
            add_parts(first, t, range[i].first * lt_param_width(p), range[i].n * lt_param_width(p));
    }
}

void plan_run_parts(lt_plan *first)
{
    stretch s = { first, 0, plan_next_share(first, 0) };

    run_all(&s);
    while (s.end < first->n_steps) {
        s.begin = s.end;
        s.end = plan_next_share(first, s.begin + 1);
        run_all(&s);
    }
    add_gradients(first);
}

void plan_run_parts_at(lt_plan *first, int step)
{
    const plan_share_fn share = first->n_parts > 1 ? plan_share_of(first, step) : NULL;

    for (int k = 0; share && k < first->n_parts; k++)
        share(&first->part[k]->step[step].call);
    for (int k = 0; k < first->n_parts; k++)
        plan_run_at(first->part[k], step);
    if (first->n_parts > 1 && step + 1 == first->n_steps)
        add_gradients(first);
}
