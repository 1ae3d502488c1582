/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One step: the shards of a batch, their gradients over the tree, the optimiser. A step whose gradient is
 * not finite changes nothing but the counts.
 */
#include "train/trainer_internal.h"

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
    const int n_shards = t->config.optim.shards, first = shard * c->parts * c->record.batch;
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

/* Gradients of the batch into the parameters, losses into the record; the number of shards with samples. */
static int run_shards(trainer *t, const void *batch, double total)
{
    int ran = 0;

    for (int s = 0; s < t->config.optim.shards; s++) {
        if (load_shard(t, batch, s, total)) {
            lt_run(t->train.plan);
            add_losses(t);
            ran++;
        } else {
            lt_params_zero_grad(t->params);
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
    for (int s = 0; s < t->config.optim.shards && !where[0]; s++)
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

static void begin_record(trainer *t)
{
    const model_ports *losses = &t->train.record.losses;
    const train_optim_config *o = &t->config.optim;
    const loader_position at = t->state.position;
    const int64_t batch = at.next ? lt_ceil_div(at.next, o->batch) - 1 : 0;
    const lt_schedule schedule = {
        .kind = (lt_schedule_kind)o->schedule, .lr = o->lr, .gamma = o->gamma, .every = o->every,
        .min_lr = o->min_lr, .epochs = o->epochs, .warmup = o->warmup,
    };

    t->record = (train_step_record){
        .step = t->state.step + 1, .epoch = (int64_t)at.epoch, .n_parts = losses->n,
        .lr = lt_schedule_lr(&schedule, (double)at.epoch + ((double)batch + 0.5) / (double)t->steps_of_epoch),
    };
    for (int i = 0; i < losses->n; i++)
        t->record.part_name[i] = losses->port[i].name;
}

lt_status trainer_step(trainer *t, const void *batch)
{
    const double total = t->config.task->weight(batch);
    lt_status st = LT_OK;
    char where[256];

    begin_record(t);
    if (total > 0) {
        const int ran = run_shards(t, batch, total);

        t->record.grad_norm = lt_optim_grad_norm(t->optim);
        if (isfinite(t->record.loss) && isfinite(t->record.grad_norm) && statistics_are_finite(t)) {
            t->bad_in_a_row = 0;
            warn_of_spike(t, batch);
            lt_statistics_update(t->params, ran);
            lt_optim_step(t->optim, t->record.lr, t->record.grad_norm);
        } else {
            name_culprit(t, batch, total, where, sizeof(where));
            st = skip(t, where);
        }
    }
    t->state.step++;
    t->state.optim_steps = lt_optim_steps(t->optim);
    return st;
}
