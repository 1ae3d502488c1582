/* SPDX-License-Identifier: Apache-2.0 */
/* Actions from windows of skeletons: what the trainer asks. */
#include "tasks/action/task.h"

#include "libtensor/io/file.h"
#include "models/action/action.h"
#include "tasks/action/batch.h"
#include "tasks/action/clips.h"
#include "tasks/action/evaluate.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

struct task_run {
    lt_arena *arena;
    const train_config *config;
    action_set set;
    action_feed train, checked;
    model *model;
};

/* ---- opening ---- */

static lt_status run_open(lt_arena *arena, train_config *c, task_run **out)
{
    task_run *r = lt_arena_alloc(arena, sizeof(*r));
    lt_status st;

    *out = r;
    if (!r)
        return lt_error(LT_ENOMEM, "no memory to begin");
    *r = (task_run){ .arena = arena, .config = c };
    if (!*c->data->dir)
        return lt_error(LT_EUSAGE, "%s: data.dir: no dataset given; name its folder with --data or --set "
                        "data.dir=FOLDER", c->path);
    st = action_clips_open(arena, c, &r->set);
    if (st)
        return st;
    c->data->dir = lt_path_whole(arena, c->data->dir);
    return c->data->dir ? LT_OK : lt_error(LT_ENOMEM, "no memory to begin");
}

static void run_close(task_run *r)
{
    (void)r;                        /* all of it is in the arena */
}

static lt_status open_feed(task_run *r, const train_config *c, bool evaluation, action_feed *out)
{
    const action_data_config *d = action_data_of(c);
    const action_window_options how = action_windows_of(c, action_frames(r->model), evaluation);

    *out = (action_feed){ .set = &r->set, .T = how.frames, .min_valid = d->min_valid,
                          .streams = (action_streams)d->streams, .hide = evaluation ? 0 : d->hide,
                          .seed = (uint64_t)c->loop.seed };
    return action_windows(r->arena, &r->set, &how, &out->window, &out->count);
}

/* Validation looks at windows that are spread over its side. */
static void spread(action_feed *f, int64_t n)
{
    action_window *kept = (action_window *)f->window;

    n = lt_min_i64(n, f->count);
    for (int64_t i = 0; i < n; i++)
        kept[i] = f->window[i * f->count / n];
    f->count = n;
}

static lt_status run_build(task_run *r, const train_config *c, lt_params *set, model *out)
{
    const bool validates = c->loop.validate_every > 0 || c->loop.validate_steps > 0;
    lt_status st = train_config_model(c, NULL, set, out);

    r->model = out;
    if (!st)
        st = open_feed(r, c, false, &r->train);
    if (!st && validates)
        st = open_feed(r, c, true, &r->checked);
    if (!st && validates)
        spread(&r->checked, c->loop.validate_samples);
    return st;
}

static void run_describe(const task_run *r, train_progress *p)
{
    progress_note(p, "%-13sactions%s, %s: %lld clips of %d subjects, %lld windows of %d frames", "data",
                  r->set.synthetic ? " (synthetic)" : "", r->set.root, (long long)r->set.n, r->set.subjects,
                  (long long)r->train.count, r->train.T);
    if (r->checked.count)
        progress_note(p, "%-13s%lld windows, split by %s", "validation", (long long)r->checked.count,
                      action_data_of(r->config)->split == ACTION_BY_SUBJECT ? "subject" : "chance, which leaks");
}

static void run_facts(const task_run *r, cJSON *env)
{
    cJSON_AddStringToObject(env, "data", "actions");
    cJSON_AddBoolToObject(env, "synthetic_data", r->set.synthetic);
}

/* ---- batches ---- */

static loader_source run_samples(const task_run *r)
{
    return action_source(&r->train);
}

static loader_source run_checked(const task_run *r)
{
    return action_source(&r->checked);
}

static size_t run_sample_bytes(const task_run *r)
{
    return (size_t)r->train.T * 3 * (ACTION_BODY + ACTION_HAND_OBJECT) * sizeof(float);
}

static double batch_weight(const void *batch)
{
    return ((const action_batch *)batch)->count;
}

static const char *run_sample_name(const task_run *r, const void *batch, int i)
{
    const action_batch *b = batch;

    return i < b->count ? r->set.clip[r->train.window[b->index[i]].clip].name : NULL;
}

/* ---- the graph ---- */

static lt_status record(const void *ctx, model_record *r)
{
    action_class.record(((const task_run *)ctx)->model, true, r);
    return LT_OK;
}

static double feed(const void *ctx, const lt_plan *p, const model_record *r, const void *batch, int first, int part,
                   int n)
{
    (void)ctx, (void)part, (void)n;
    return action_batch_feed(p, r, batch, first);
}

static recipe run_recipe(const task_run *r, const task_phase *phase)
{
    (void)phase;
    return (recipe){ .ctx = r, .record = record, .feed = feed };
}

/* ---- scores ---- */

typedef struct { int cls, found; } told;

static lt_status run_score(task_run *r, const compiled *c, const void *batch, records *out, bool *no_losses)
{
    const action_batch *b = batch;
    const lt_real *logits = compiled_output(c, "logits");
    lt_status st = LT_OK;

    (void)r, (void)no_losses;
    for (int i = 0; !st && i < b->count; i++) {
        const told t = { b->cls[i], action_find(logits + i * ACTION_OUTPUTS) };

        st = records_add(out, b->index[i], &t, sizeof(t));
    }
    return st;
}

static void run_measure(task_run *r, const records *all, double *out)
{
    action_confusion c = { { { 0 } } };

    (void)r;
    for (int64_t i = 0; i < all->n; i++) {
        told t;

        memcpy(&t, records_at(all, i, NULL), sizeof(t));
        action_confusion_add(&c, t.cls, t.found);
    }
    out[0] = action_accuracy(&c);
}

static const char *const metrics[] = { "accuracy", NULL };
static const metric own_metrics[] = {
    { "accuracy", "accuracy", "", true, "share of windows whose class is found", "Bandi and Thomas 2025" },
    { .key = NULL },
};

const task action_task = {
    .name = "action", .data_size = sizeof(action_data_config), .data_keys = action_data_keys, .metrics = metrics,
    .own_metrics = own_metrics, .open = run_open, .close = run_close, .build = run_build, .describe = run_describe,
    .facts = run_facts, .samples = run_samples, .checked = run_checked, .sample_bytes = run_sample_bytes,
    .recipe = run_recipe, .weight = batch_weight, .sample_name = run_sample_name, .score = run_score,
    .measure = run_measure, .evaluate = action_evaluate_run, .scores = action_score_keys,
};
