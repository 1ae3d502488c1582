/* SPDX-License-Identifier: Apache-2.0 */
/* Norms and steps. Weights go in chunks of a fixed size; those that are stepped by rows go range by range. */
#include "libtensor/base/parallel.h"
#include "libtensor/graph/internal.h"
#include "libtensor/optim/internal.h"

#include <math.h>
#include <string.h>

enum { ROW_CHUNK = 1 << 14, MOST_CHUNKS = 64 };     /* of a range of rows; part of the norm's value */

/* A range of rows of a slot, cut into tasks of so many rows. */
typedef struct {
    const lt_optim *o;
    const optim_slot *s;
    lt_row_range range;
    int64_t rows;                   /* of a task */
    double partial[MOST_CHUNKS];
} row_job;

static row_job row_job_of(const lt_optim *o, const optim_slot *s, lt_row_range range)
{
    const int64_t few = lt_max_i64(1, ROW_CHUNK / lt_param_width(s->p));

    return (row_job){ .o = o, .s = s, .range = range, .rows = lt_max_i64(few, lt_ceil_div(range.n, MOST_CHUNKS)) };
}

static lt_row_range task_rows(const row_job *j, int64_t k)
{
    const int64_t at = k * j->rows;

    return (lt_row_range){ j->range.first + at, lt_min_i64(j->rows, j->range.n - at) };
}

static int64_t run_rows(row_job *j, lt_task_fn fn)
{
    const int64_t n = lt_ceil_div(j->range.n, j->rows);

    lt_parallel_for(n, fn, j);
    return n;
}

/* ---- the norm ----------------------------------------------------------------------------------------- */

static void norm_chunk(void *ctx, int64_t k)
{
    const lt_optim *o = ctx;
    int64_t at;
    size_t n;
    const optim_slot *s = optim_chunk(o, k, &at, &n);

    o->partial[k] = s->p->frozen || !optim_chosen(o->measured, s->group) ? 0 : lt_k->sumsq(s->p->grad + at, n);
}

static void norm_rows(void *ctx, int64_t k)
{
    row_job *j = ctx;
    const lt_row_range r = task_rows(j, k);
    const int64_t width = lt_param_width(j->s->p);

    j->partial[k] = lt_k->sumsq(j->s->p->grad + r.first * width, (size_t)(r.n * width));
}

static double sumsq_of_rows(const lt_optim *o, const optim_slot *s)
{
    double sum = 0;
    int n;
    const lt_row_range *range = lt_param_touched(s->p, &n);

    for (int i = 0; i < n; i++) {
        row_job j = row_job_of(o, s, range[i]);
        const int64_t tasks = run_rows(&j, norm_rows);

        for (int64_t k = 0; k < tasks; k++)
            sum += j.partial[k];
    }
    return sum;
}

double lt_optim_groups_norm(lt_optim *o, uint64_t groups)
{
    double sum = 0;

    o->measured = groups;
    for (int k = 0; k < o->n_groups; k++)
        o->group[k].sumsq = 0;
    lt_parallel_for(o->n_chunks, norm_chunk, o);
    for (int i = 0; i < o->n_slots; i++) {
        const optim_slot *s = &o->slot[i];
        double *of_group = &o->group[s->group].sumsq;

        for (int64_t k = 0; k < s->n_chunks; k++)
            *of_group += o->partial[s->first_chunk + k];
        if (s->p->rows && !s->p->frozen && optim_chosen(groups, s->group))
            *of_group += sumsq_of_rows(o, s);
    }
    for (int k = 0; k < o->n_groups; k++)
        sum += o->group[k].sumsq;
    return sqrt(sum);
}

double lt_optim_grad_norm(lt_optim *o)
{
    return lt_optim_groups_norm(o, UINT64_MAX);
}

/* What group k is clipped by */
static double clipping_norm(const lt_optim *o, uint64_t groups, int k)
{
    double sum = 0;

    if (o->group[k].recipe.clip_alone)
        return sqrt(o->group[k].sumsq);
    for (int i = 0; i < o->n_groups; i++)
        if (optim_chosen(groups, i) && o->group[i].recipe.clip_norm > 0 && !o->group[i].recipe.clip_alone)
            sum += o->group[i].sumsq;
    return sqrt(sum);
}

/* ---- one piece ---------------------------------------------------------------------------------------- */

static void update_ema(lt_real *ema, const lt_real *w, size_t n, lt_real keep)
{
    for (size_t i = 0; i < n; i++)
        ema[i] = keep * ema[i] + (1 - keep) * w[i];
}

/* n elements of a slot from `at` on, by what their group does in this step */
static void move(const optim_slot *s, int64_t at, size_t n, const optim_group *g)
{
    lt_real *w = s->p->data + at;
    const lt_real rate = (lt_real)s->p->rate;
    lt_adam_step adam = g->adam;
    lt_sgd_step sgd = g->sgd;

    adam.lr *= rate;
    sgd.lr *= rate;
    if (!s->decays)
        adam.l2 = adam.decay = sgd.l2 = 0;
    if (g->recipe.kind == LT_SGD)
        lt_k->sgd(w, s->m.data + at, s->p->grad + at, &sgd, n);
    else
        lt_k->adam(w, s->m.data + at, s->v.data + at, s->p->grad + at, &adam, n);
    if (s->ema.data)
        update_ema(s->ema.data + at, w, n, g->keep);
}

static void step_chunk(void *ctx, int64_t k)
{
    const lt_optim *o = ctx;
    int64_t at;
    size_t n;
    const optim_slot *s = optim_chunk(o, k, &at, &n);

    if (o->group[s->group].steps && !s->p->frozen && !optim_by_muon(o, s))  /* frozen since the optimiser was made */
        move(s, at, n, &o->group[s->group]);
}

/* 1 - beta^t of the beta that the kernel has: 1 - 0.999f is not 0.001, by 1.3e-5 of it. */
static lt_real correction(double beta, double t)
{
    return (lt_real)(1 - pow((lt_real)beta, t));
}

/* Without tau, until its decay is reached, the average is over about the last tenth of the steps: weights of the
 * beginning would else stay in it for a few times 1 / (1 - decay) steps. */
static double ema_keep(const lt_optim_average *a, double t)
{
    return a->tau > 0 ? a->decay * (1 - exp(-t / a->tau)) : fmin(a->decay, t / (t + 9));
}

/* What depends on how many steps were taken. */
static void set_time(const lt_optim *o, optim_group *g, double t)
{
    g->adam.correct1 = correction(g->recipe.beta1, t);
    g->adam.correct2 = correction(g->recipe.beta2, t);
    g->keep = (lt_real)ema_keep(&o->average, t);
}

/* Rows of one clock, mostly all of them, go together. */
static void step_rows(void *ctx, int64_t k)
{
    const row_job *j = ctx;
    const optim_slot *s = j->s;
    const lt_row_range r = task_rows(j, k);
    const int64_t width = lt_param_width(s->p);
    optim_group g = j->o->group[s->group];
    int64_t n;

    for (int64_t at = r.first; at < r.first + r.n; at += n) {
        lt_real *clock = s->clock.data + at;
        const lt_real t = *clock;

        for (n = 0; at + n < r.first + r.n && clock[n] == t; n++)
            clock[n] = t + 1;
        set_time(j->o, &g, t + 1);
        move(s, at * width, (size_t)(n * width), &g);
    }
}

static void step_touched(const lt_optim *o, const optim_slot *s)
{
    int n;
    const lt_row_range *range = lt_param_touched(s->p, &n);

    for (int i = 0; i < n; i++) {
        row_job j = row_job_of(o, s, range[i]);

        run_rows(&j, step_rows);
    }
}

/* ---- the step ----------------------------------------------------------------------------------------- */

/* Group k takes a step. */
static void prepare(lt_optim *o, int k, double lr, double momentum, double norm)
{
    optim_group *g = &o->group[k];
    const lt_optim_group *r = &g->recipe;
    const lt_real scale = (lt_real)(r->clip_norm > 0 && norm > r->clip_norm ? r->clip_norm / norm : 1);

    g->steps = true;
    g->clock++;
    g->adam = (lt_adam_step){
        .lr = (lt_real)lr, .beta1 = (lt_real)r->beta1, .beta2 = (lt_real)r->beta2, .eps = (lt_real)r->eps,
        .l2 = (lt_real)(r->kind == LT_ADAM ? r->weight_decay : 0),
        .decay = (lt_real)(r->kind == LT_ADAMW || r->kind == LT_MUON ? r->weight_decay : 0), .grad_scale = scale,
    };
    g->sgd = (lt_sgd_step){
        .lr = (lt_real)lr, .momentum = (lt_real)momentum, .l2 = (lt_real)r->weight_decay, .grad_scale = scale,
        .nesterov = r->nesterov,
    };
    set_time(o, g, g->clock);
}

static void step_matrix(const lt_optim *o, const optim_slot *s)
{
    optim_muon(o, s);
    if (s->ema.data)
        update_ema(s->ema.data, s->p->data, (size_t)lt_param_numel(s->p), o->group[s->group].keep);
}

static void take_step(lt_optim *o)
{
    int batches;

    o->steps++;
    lt_parallel_for(o->n_chunks, step_chunk, o);
    for (int i = 0; i < o->n_slots; i++)
        if (o->group[o->slot[i].group].steps && !o->slot[i].p->frozen && optim_by_muon(o, &o->slot[i]))
            step_matrix(o, &o->slot[i]);
    for (int i = 0; i < o->n_slots; i++)
        if (o->slot[i].p->rows && !o->slot[i].p->frozen && o->group[o->slot[i].group].steps)
            step_touched(o, &o->slot[i]);
    if (lt_params_take_batches(o->set, &batches))
        optim_update_statistics(o->set, batches);
    for (int i = 0; i < o->n_statistics; i++) {
        const optim_statistic *s = &o->statistic[i];

        update_ema(s->ema, s->p->data, (size_t)lt_param_numel(s->p),
                   (lt_real)ema_keep(&o->average, (double)o->steps));
    }
    lt_params_changed(o->set);
}

void lt_optim_step(lt_optim *o, double lr, double norm)
{
    for (int k = 0; k < o->n_groups; k++)
        prepare(o, k, lr, o->group[k].recipe.momentum, norm);
    take_step(o);
}

static double momentum_at(const lt_optim_group *g, double time)
{
    const double warmup = g->schedule.warmup;

    if (!(g->warmup_momentum > 0) || !(time < warmup))
        return g->momentum;
    return g->warmup_momentum + (g->momentum - g->warmup_momentum) * time / warmup;
}

void lt_optim_step_groups(lt_optim *o, const lt_optim_now *now)
{
    for (int k = 0; k < o->n_groups; k++) {
        const lt_optim_group *g = &o->group[k].recipe;
        const double time = g->by_step ? now->step : now->epoch;

        o->group[k].steps = false;
        if (optim_chosen(now->groups, k))
            prepare(o, k, lt_schedule_lr(&g->schedule, time), momentum_at(g, time),
                    clipping_norm(o, now->groups, k));
    }
    take_step(o);
}

void lt_optim_forget(lt_optim *o, const lt_param *p, int64_t first, int64_t n)
{
    const int64_t width = lt_param_width(p), end = lt_min_i64(first + n, p->shape.dim[0]);

    first = lt_max_i64(first, 0);
    for (int i = 0; i < o->n_slots; i++) {
        const optim_slot *s = &o->slot[i];
        const size_t bytes = first < end ? (size_t)((end - first) * width) * sizeof(lt_real) : 0;

        if (s->p != p || !bytes)
            continue;
        memset(s->m.data + first * width, 0, bytes);
        if (s->v.data)
            memset(s->v.data + first * width, 0, bytes);
    }
}
