/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One step: the shards of a batch, their gradients over the tree, the optimiser. A step whose gradient is
 * not finite changes nothing but the counts.
 */
#include "train/trainer_internal.h"

#include "libtensor/graph/rows.h"

#include <inttypes.h>
#include <math.h>

static double value(const lt_plan *p, const lt_tensor *tensor)
{
    return *(const lt_real *)lt_plan_data(p, tensor);
}

/* Fill the plan with a shard and set what depends on it; false when no sample counts. */
static bool load_shard(trainer *t, const void *batch, int shard, double total)
{
    const compiled *c = &t->train;
    const int n_shards = t->phase.shards, first = shard * c->parts * c->record.batch;
    double share = 0;

    lt_plan_set_step(c->plan, t->state.seed, (uint64_t)(t->state.step * n_shards + shard));
    for (int k = 0; k < c->parts; k++) {
        lt_plan *part = lt_plan_part(c->plan, k);

        t->share[k] = c->by.feed(c->by.ctx, part, &c->record, batch, first, k, c->parts) / total;
        lt_plan_set_loss_weight(part, t->share[k]);
        share += t->share[k];
    }
    return share > 0;
}

static void add_losses(trainer *t)
{
    const model_record *r = &t->train.record;

    for (int k = 0; k < t->train.parts; k++) {
        const lt_plan *part = lt_plan_part(t->train.plan, k);

        t->record.loss += t->share[k] * value(part, r->loss);
        for (int i = 0; i < r->losses.n; i++)
            t->record.part[i] += t->share[k] * value(part, r->losses.port[i].tensor);
    }
}

/* A shard without samples saw nothing. */
static void clear_observed(const trainer *t)
{
    int64_t n = 0;
    lt_real *x = t->config.task->observed ? t->config.task->observed(t->run, &n) : NULL;

    for (int64_t i = 0; i < n; i++)
        x[i] = 0;
}

/* Gradients of the batch into the parameters, losses into the record; the number of shards with samples. */
static int run_shards(trainer *t, const void *batch, double total)
{
    const task *of = t->config.task;
    int ran = 0;

    for (int s = 0; s < t->phase.shards; s++) {
        if (load_shard(t, batch, s, total)) {
            lt_run(t->train.plan);
            add_losses(t);
            if (of->observe)
                of->observe(t->run, &t->train, batch, s * t->train.parts * t->train.record.batch);
            ran++;
        } else {
            lt_params_zero_grad(t->params);
            clear_observed(t);
        }
        tree_sum_add(t->sum, s);
    }
    return ran;
}

/* What the batches measured must be finite as well: an infinite variance has a gradient of 0. */
static bool statistics_are_finite(const trainer *t)
{
    for (const lt_param *p = lt_params_first(t->params); p; p = p->next)
        for (int64_t i = 0; p->kind == LT_STATISTIC && p->grad && i < lt_param_numel(p); i++)
            if (!isfinite(p->grad[i]))
                return false;
    return true;
}

/* Run the shards again, tensor by tensor, until one is not finite. */
static void name_culprit(trainer *t, const void *batch, double total, char *where, size_t bytes)
{
    where[0] = '\0';
    for (int s = 0; s < t->phase.shards && !where[0]; s++)
        if (load_shard(t, batch, s, total))
            lt_plan_find_nonfinite(t->train.plan, where, bytes);
    if (!where[0])
        snprintf(where, bytes, "the sum of the shards' gradients");
}

static lt_status skip(trainer *t, const char *where)
{
    const int limit = t->config.loop.max_bad_steps;

    t->state.skipped++;
    t->bad_in_a_row++;
    t->record.bad = lt_arena_strdup(t->arena, where);
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

    if (times > 0)
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

static void begin_record(trainer *t)
{
    const model_ports *losses = &t->train.record.losses;
    const train_optim_config *o = &t->config.optim;
    const lt_schedule schedule = {
        .kind = (lt_schedule_kind)o->schedule, .lr = o->lr, .gamma = o->gamma, .every = o->every,
        .min_lr = o->min_lr, .epochs = o->epochs, .warmup = o->warmup,
    };

    t->record = (train_step_record){
        .step = t->state.step + 1, .epoch = (int64_t)t->state.position.epoch, .n_parts = losses->n,
        .lr = lt_schedule_lr(&schedule, epoch_of(t)),
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
    const int ran = run_shards(t, batch, total);
    char where[256];

    t->record.grad_norm = grad_norm(t);
    if (isfinite(t->record.loss) && isfinite(t->record.grad_norm) && statistics_are_finite(t)) {
        t->bad_in_a_row = 0;
        warn_of_spike(t, batch);
        return move(t, ran);
    }
    name_culprit(t, batch, total, where, sizeof(where));
    return skip(t, where);
}

lt_status trainer_step(trainer *t, const void *batch)
{
    const task *of = t->config.task;
    const double total = of->weight(batch);
    lt_status st = LT_OK;

    begin_record(t);
    lt_params_untouch(t->params);
    if (of->rows)
        st = of->rows(t->run, batch);
    if (st == LT_OK && total > 0)
        st = learn(t, batch, total);
    t->state.step++;
    t->state.optim_steps = lt_optim_steps(t->optim);
    return st;
}
