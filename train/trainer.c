/* SPDX-License-Identifier: Apache-2.0 */
#include "train/trainer_internal.h"

#include "libtensor/base/clock.h"
#include "train/signals.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- validation --------------------------------------------------------------------------------------- */

static bool stop_asked(void)
{
    return signals_stop() != 0;
}

static bool every(int64_t n, int64_t period)
{
    return period > 0 && n % period == 0;
}

/* A step is validated once, also when the run was stopped before it came to that. */
static bool validation_is_due(const trainer *t)
{
    const train_loop_config *c = &t->config.loop;
    const int64_t step = t->state.step, epoch = step / t->steps_of_epoch;

    if (!t->check.plan || step == 0 || t->state.validated == step)
        return false;
    return every(step, c->validate_steps) || step == t->total_steps
        || (step % t->steps_of_epoch == 0 && every(epoch, c->validate_every));
}

static lt_status score(trainer *t, train_validation *v)
{
    const bool ema = t->config.optim.ema_decay > 0;
    lt_status st;

    if (ema)
        lt_optim_swap_ema(t->optim);
    st = trainer_validate(t, v);
    if (ema)
        lt_optim_swap_ema(t->optim);
    return st;
}

static lt_status flush_log(trainer *t)
{
    const lt_status st = train_log_flush(&t->log);

    return st ? lt_error_prefix(st, "%s", t->opt->out) : LT_OK;
}

static bool is_best(const trainer *t, const train_validation *v)
{
    if (!t->state.best_step)
        return isfinite(v->value[0]);
    return metric_better(v->metric[0], v->value[0], t->state.best);
}

static void tell(trainer *t, const train_validation *v)
{
    char text[256] = "";
    size_t n = 0;

    for (int i = 0; i < v->n_metrics && n < sizeof(text); i++)
        n += (size_t)snprintf(text + n, sizeof(text) - n, "%s %.2f%s%s, ", v->metric[i]->name, v->value[i],
                              *v->metric[i]->unit ? " " : "", v->metric[i]->unit);
    if (!isnan(v->loss) && n < sizeof(text))    /* some splits keep to themselves what the losses need */
        snprintf(text + n, sizeof(text) - n, "loss %.4g, ", v->loss);
    progress_note(&t->progress, "validation at step %" PRId64 ": %s%" PRId64 " samples%s", v->step, text, v->samples,
                  t->improved ? ", best" : "");
}

static const metric *metric_of(const task *of, const char *key)
{
    for (const metric *own = of->own_metrics; own && own->key; own++)
        if (strcmp(own->key, key) == 0)
            return own;
    return metric_find(key);
}

static lt_status validate(trainer *t)
{
    train_validation v = { .step = t->state.step, .epoch = (int64_t)t->state.position.epoch };
    lt_status st;

    for (const char *const *key = t->config.task->metrics; *key; key++)
        v.metric[v.n_metrics++] = metric_of(t->config.task, *key);
    st = score(t, &v);
    if (st)
        return st;
    train_log_validation(&t->log, &v);
    st = flush_log(t);
    if (st)                     /* what is not written down has not happened: the resumed run validates again */
        return st;
    t->state.validated = t->state.step;
    if (is_best(t, &v)) {
        t->state.best = v.value[0];
        t->state.best_step = v.step;
        t->improved = true;
    }
    tell(t, &v);
    if (t->opt->validated)
        t->opt->validated(t->opt->ctx, &v);
    return LT_OK;
}

/* ---- between steps ------------------------------------------------------------------------------------ */

static bool save_is_due(const trainer *t)
{
    const train_loop_config *c = &t->config.loop;

    if (t->improved || signals_take_save())
        return true;
    if (t->state.step == t->first_step)
        return false;
    return every(t->state.step, c->checkpoint_steps)
        || (c->checkpoint_minutes > 0 && lt_clock() - t->saved_at > 60 * c->checkpoint_minutes);
}

/* Validate, save, stop: whatever stands at this step. LT_ESTOPPED when a signal came to any rank and all is saved. */
static lt_status between_steps(trainer *t)
{
    const bool lead = ranks_lead(t->opt->ranks);
    lt_status st = LT_OK;

    if (lead && !stop_asked() && validation_is_due(t))
        st = validate(t);
    if (st && st != LT_ESTOPPED)
        return st;
    t->signal = signals_stop();         /* once: one from here on finds the next step */
    st = ranks_most(t->opt->ranks, &t->signal);
    if (st == LT_OK && lead && (t->signal || save_is_due(t)))
        st = trainer_save(t);
    if (st || !t->signal)
        return st;
    return lt_error(LT_ESTOPPED, "stopped by signal %d at step %" PRId64 "; go on with --resume",
                    t->signal, t->state.step);
}

/* ---- the loop ----------------------------------------------------------------------------------------- */

static lt_status start_loader(trainer *t)
{
    const train_config *c = &t->config;
    loader_options o = {
        .batch = t->phase.batch, .threads = c->data->threads, .ahead = c->data->ahead, .shuffle = !t->samples.ordered,
        .seed = t->state.seed, .tolerate = c->data->tolerate,
    };

    shards_slots(t, &o.first_slot, &o.n_slots);
    if (t->state.position.next > t->samples.count)
        return lt_error(LT_EINVAL, "%s: stopped at sample %lld of an epoch, but %s has %lld to train on; --data says "
                        "where the run's own data are", t->opt->out, (long long)t->state.position.next,
                        c->data->dir, (long long)t->samples.count);
    return loader_new(&t->samples, &o, t->state.position, &t->loader);
}

static lt_status next_batch(trainer *t, void **batch)
{
    lt_status st = loader_next(t->loader, batch);

    if (st == LT_OK && !*batch)                 /* the epoch ended */
        st = loader_next(t->loader, batch);
    if (st)
        return st;
    for (; t->samples_warned < loader_skipped(t->loader); t->samples_warned++)
        progress_warn(&t->progress, "%s", loader_skipped_line(t->loader, t->samples_warned));
    t->state.position = loader_where(t->loader);
    return LT_OK;
}

/* Smooth the time of a step, so that the rate and the time left do not jump. */
static void clock_step(trainer *t, double began)
{
    const double now = lt_clock(), took = now - began;

    t->step_seconds = t->step_seconds > 0 ? 0.9 * t->step_seconds + 0.1 * took : took;
    t->record.seconds = now - t->began_at;
    t->record.ms = 1e3 * took;
    t->record.img_per_s = t->phase.batch / t->step_seconds;
}

static lt_status report(trainer *t, bool last)
{
    const int64_t here = t->state.step - t->first_step, in_epoch = t->state.step % t->steps_of_epoch;
    const train_progress_state s = {
        .epochs = (int)lt_ceil_div(t->total_steps, t->steps_of_epoch),
        .step_of_epoch = in_epoch ? in_epoch : t->steps_of_epoch,
        .steps_of_epoch = t->steps_of_epoch, .skipped = t->state.skipped,
        .eta_seconds = t->step_seconds * (double)(t->total_steps - t->state.step),
    };

    if (!ranks_lead(t->opt->ranks))
        return LT_OK;
    progress_step(&t->progress, &t->record, &s, last || here == 20);
    if (last || t->record.bad || every(t->state.step, t->config.loop.log_every))
        train_log_step(&t->log, &t->record);
    return flush_log(t);
}

/* What the next step needs, where it is of another phase or parameters have other rows. */
static lt_status next_phase(trainer *t)
{
    const int batch = t->phase.batch;
    const lt_status st = trainer_enter(t);

    if (st || t->phase.batch == batch)
        return st;
    loader_free(t->loader);
    t->loader = NULL;
    t->samples_warned = 0;
    return start_loader(t);
}

static lt_status one_step(trainer *t)
{
    const double began = lt_clock();
    const loader_position before = t->state.position;
    void *batch = NULL;
    lt_status st, logged;

    if (t->opt->before_step)
        t->opt->before_step(t->opt->ctx, t->state.step + 1, t->params);
    st = next_batch(t, &batch);
    if (st)
        return st;
    st = trainer_step(t, batch);
    if (st && st != LT_ENUMERIC)                /* the step was not taken */
        t->state.position = before;
    clock_step(t, began);
    if (t->config.task->counts)
        t->record.n_counts = t->config.task->counts(t->run, t->record.count);
    logged = report(t, st || t->state.step == t->total_steps);
    st = st ? st : logged;
    return st ? st : next_phase(t);
}

/* What ends a run costs none of the steps before it; the first line is the one that counts. */
static lt_status keep_steps(trainer *t, lt_status st)
{
    char line[1024];

    if (st == LT_ESTOPPED || st == LT_ENUMERIC || t->torn || t->state.step == t->first_step
        || t->state.step == t->saved_step)
        return st;
    snprintf(line, sizeof(line), "%s", lt_last_error());
    if (ranks_lead(t->opt->ranks))
        trainer_save(t);
    return lt_error(st, "%s", line);
}

static lt_status loop(trainer *t)
{
    lt_status st = between_steps(t);

    while (st == LT_OK && t->state.step < t->total_steps) {
        st = one_step(t);
        if (st == LT_OK)
            st = between_steps(t);
    }
    if (st)
        return keep_steps(t, st);
    return ranks_lead(t->opt->ranks) ? trainer_save(t) : LT_OK;
}

/* ---- from the beginning to the end -------------------------------------------------------------------- */

static lt_status train(trainer *t)
{
    const bool lead = ranks_lead(t->opt->ranks);
    lt_status st = start_loader(t);     /* first: a position that the data do not have leaves the folder alone */

    if (st == LT_OK)
        st = run_folder_agree(t);
    if (st == LT_OK && lead)
        st = run_folder_make(t);
    if (st == LT_OK && lead)
        st = train_log_open(t->arena, t->opt->out, t->state.step, &t->log);
    if (st)
        return st;
    t->began_at = t->saved_at = lt_clock();
    t->first_step = t->state.step;
    signals_install();                          /* before there are steps to keep, a signal ends the process at once */
    st = loop(t);
    if (st == LT_OK && lead && t->config.task->conclude)
        t->config.task->conclude(t->run, &t->progress);
    if (st == LT_OK)
        progress_note(&t->progress, "done: %" PRId64 " steps, %" PRId64 " skipped, in %s", t->state.step,
                      t->state.skipped, t->opt->out);
    signals_restore();
    return st;
}

static void fill_result(const trainer *t, double eta, train_result *out)
{
    *out = (train_result){
        .step = t->state.step, .steps_here = t->state.step - t->first_step, .skipped = t->state.skipped,
        .loss = t->record.loss, .best = t->state.best, .img_per_s = t->record.img_per_s,
        .signal = t->signal, .steps = t->total_steps, .eta_seconds = eta,
    };
    if (t->optim && t->sum && t->train.plan) {
        out->plan_bytes = trainer_plan_bytes(t);
        out->bytes = trainer_bytes(t);
        out->disk_bytes = trainer_disk_bytes(t);
    }
}

lt_status train_run(const train_options *o, train_result *out)
{
    trainer t;
    double eta = 0;
    lt_status st;

    st = trainer_init(&t, o);
    if (st == LT_OK && o->resume)
        st = trainer_resume(&t);
    else if (st == LT_OK && ranks_lead(o->ranks))
        st = run_folder_check(&t);
    if (st == LT_OK)
        st = trainer_enter(&t);
    if (st == LT_OK) {
        trainer_describe(&t);
        st = trainer_check_disk(&t);
    }
    if (st == LT_OK)
        st = o->dry_run ? forecast_seconds(&t, &eta) : train(&t);
    if (st)
        progress_log(&t.progress, "ended: %s", lt_last_error());
    if (st && st != LT_ESTOPPED && o->ranks)
        o->ranks->fail(o->ranks->ctx);
    if (out)
        fill_result(&t, eta, out);
    trainer_fini(&t);
    return st;
}
