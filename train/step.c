/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One step: the gradients of a batch's shards, the optimiser. A step whose gradient is not finite changes nothing but
 * the counts.
 */
#include "train/trainer_internal.h"

#include "libtensor/graph/rows.h"

#include <inttypes.h>
#include <math.h>

/* What the batches measured must be finite as well: an infinite variance has a gradient of 0. */
static bool statistics_are_finite(const trainer *t)
{
    for (const lt_param *p = lt_params_first(t->params); p; p = p->next)
        for (int64_t i = 0; p->kind == LT_STATISTIC && p->grad && i < lt_param_numel(p); i++)
            if (!isfinite(p->grad[i]))
                return false;
    return true;
}

static lt_status skip(trainer *t, const char *where)
{
    const int limit = t->config.loop.max_bad_steps;

    t->state.skipped++;
    t->bad_in_a_row++;
    t->record.bad = lt_arena_strdup(t->arena, where);
    if (ranks_lead(t->opt->ranks))
        progress_warn(&t->progress, "step %" PRId64 " skipped: %s is not finite", t->record.step, where);
    if (t->bad_in_a_row < limit)
        return LT_OK;
    return lt_error(LT_ENUMERIC, "step %" PRId64 ": %d steps in a row without a finite gradient; the first bad "
                    "tensor is %s; try a lower optim.lr or optim.clip_norm=1", t->record.step, limit, where);
}

static void warn_of_spike(trainer *t, const void *batch)
{
    const double times = train_log_spike(&t->log, t->record.grad_norm);
    const task *of = t->config.task;
    const char *second = of->sample_name(t->run, batch, 1);

    if (times > 0 && ranks_lead(t->opt->ranks))
        progress_warn(&t->progress, "step %" PRId64 ": the gradient's norm %.3g is %.0f times the usual; its "
                      "first samples are %s%s%s", t->record.step, t->record.grad_norm, times,
                      of->sample_name(t->run, batch, 0), second ? ", " : "", second ? second : "");
}

/* Where the step is in the run, in epochs: the middle of its batch */
static double epoch_of(const trainer *t)
{
    const loader_position at = t->state.position;
    const int64_t batch = at.next ? lt_ceil_div(at.next, t->phase.batch) - 1 : 0;

    return (double)at.epoch + ((double)batch + 0.5) / (double)lt_ceil_div(t->samples.count, t->phase.batch);
}

/* Of the first group that steps; of all weights where there are none */
static double rate(const trainer *t)
{
    const train_optim_config *o = &t->config.optim;
    const lt_schedule schedule = {
        .kind = (lt_schedule_kind)o->schedule, .lr = o->lr, .gamma = o->gamma, .every = o->every,
        .min_lr = o->min_lr, .epochs = o->epochs, .warmup = o->warmup,
    };
    const lt_optim_group *group;
    lt_optim_average average;
    int n, k = 0;

    if (!t->config.task->groups)
        return lt_schedule_lr(&schedule, epoch_of(t));
    group = t->config.task->groups(t->run, &n, &average);
    while (k + 1 < n && !(t->phase.groups >> k & 1))
        k++;
    return lt_schedule_lr(&group[k].schedule, group[k].by_step ? (double)t->state.step : epoch_of(t));
}

static void begin_record(trainer *t)
{
    const model_ports *losses = &t->train.record.losses;

    t->record = (train_step_record){
        .step = t->state.step + 1, .phase = t->phase.name, .epoch = (int64_t)t->state.position.epoch,
        .n_parts = losses->n, .lr = rate(t),
    };
    for (int i = 0; i < losses->n; i++)
        t->record.part_name[i] = losses->port[i].name;
}

static double grad_norm(const trainer *t)
{
    return t->config.task->groups ? lt_optim_groups_norm(t->optim, t->phase.groups) : lt_optim_grad_norm(t->optim);
}

/* The weights move. What adapts comes before, as in 3D Gaussian splatting: rows that are cloned or moved take their
 * gradients along. */
static lt_status move(trainer *t, int ran)
{
    const task *of = t->config.task;
    const lt_optim_now now = { t->phase.groups, (double)t->state.step, epoch_of(t) };
    const lt_status st = of->adapt ? of->adapt(t->run, t->record.step, t->optim) : LT_OK;

    t->torn = st != LT_OK;
    if (st)
        return st;
    lt_statistics_update(t->params, ran);
    if (of->groups)
        lt_optim_step_groups(t->optim, &now);
    else
        lt_optim_step(t->optim, t->record.lr, t->record.grad_norm);
    return LT_OK;
}

static lt_status learn(trainer *t, const void *batch, double total)
{
    char where[SHARDS_WHERE];
    int ran;
    lt_status st = shards_run(t, batch, total, &ran);

    if (st)
        return st;
    t->record.grad_norm = grad_norm(t);
    if (isfinite(t->record.loss) && isfinite(t->record.grad_norm) && statistics_are_finite(t)) {
        t->bad_in_a_row = 0;
        warn_of_spike(t, batch);
        return move(t, ran);
    }
    st = shards_find_culprit(t, batch, total, where);
    return st ? st : skip(t, where);
}

lt_status trainer_step(trainer *t, const void *batch)
{
    const task *of = t->config.task;
    double total = of->weight(batch);
    lt_status st;

    begin_record(t);
    lt_params_untouch(t->params);
    st = of->rows ? of->rows(t->run, batch, t->state.step) : ranks_add(t->opt->ranks, &total);
    if (st == LT_OK && total > 0)
        st = learn(t, batch, total);
    if (st && st != LT_ENUMERIC)
        return st;
    t->state.step++;
    t->state.optim_steps = lt_optim_steps(t->optim);
    return st;
}
