/* SPDX-License-Identifier: Apache-2.0 */
/* The task of models that find objects in pictures: what the trainer asks of it. */
#include "tasks/detect/task.h"

#include "estimate/detection/class_names.h"
#include "estimate/detection/found.h"
#include "estimate/feed.h"
#include "libtensor/io/file.h"
#include "tasks/detect/batch.h"
#include "tasks/detect/evaluate.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

struct task_run {
    lt_arena *arena;                /* the run's */
    const train_config *config;
    detection_set *train, *evaluation;          /* the second: NULL, nothing is validated */
    detect_feed feed, check_feed;
    model *model;
    lt_optim_group group[DETECT_GROUPS];
};

/* ---- opening ---------------------------------------------------------------------------------------------- */

static bool validates(const train_config *c)
{
    return c->loop.validate_every > 0 || c->loop.validate_steps > 0;
}

enum { EVALUATION_SEED = 1000 };

static lt_status open_sets(task_run *r, const train_config *c)
{
    const char *root = c->data->dir;
    lt_status st;

    if (!*root)
        return lt_error(LT_EUSAGE, "%s: data.dir: no dataset given; name its folder with --data or "
                        "--set data.dir=FOLDER", c->path);
    st = detection_open(r->arena, root, "train", &r->train);
    if (st == LT_OK && r->train->seed == EVALUATION_SEED)
        return lt_error(LT_EINVAL, "%s: is the set that detectors are compared on (seed %d): train on another seed's",
                        root, EVALUATION_SEED);
    if (st == LT_OK && validates(c))
        st = detection_open(r->arena, root, "evaluation", &r->evaluation);
    if (st == LT_OK && r->evaluation && r->evaluation->classes != r->train->classes)
        return lt_error(LT_EINVAL, "%s: has %d classes to train and %d to validate", root, r->train->classes,
                        r->evaluation->classes);
    return st;
}

static lt_status run_open(lt_arena *arena, train_config *c, task_run **out)
{
    task_run *r = lt_arena_alloc(arena, sizeof(*r));
    lt_status st;

    *out = r;
    if (!r)
        return lt_error(LT_ENOMEM, "no memory to begin");
    r->arena = arena;
    r->config = c;
    st = open_sets(r, c);
    if (st)
        return st;
    c->data->dir = lt_path_whole(arena, c->data->dir);
    ((detect_config *)c->data)->names = class_names_join(arena, r->train->class_name, r->train->classes);
    return c->data->dir && detect_config_of(c)->names ? LT_OK : lt_error(LT_ENOMEM, "no memory to begin");
}

static void run_close(task_run *r)
{
    (void)r;                        /* all of it is in the arena */
}

static lt_status run_build(task_run *r, const train_config *c, lt_params *set, model *out)
{
    const lt_status st = train_config_model(c, NULL, set, out);
    const csp_seg_config *m = st ? NULL : csp_seg_config_of(out);

    if (st)
        return st;
    if (m->classes != r->train->classes)
        return lt_error(LT_EINVAL, "%s: model.classes: %d, but %s has %d: give --set model.classes=%d", c->path,
                        m->classes, r->train->list, r->train->classes, r->train->classes);
    r->model = out;
    r->feed = (detect_feed){ .set = r->train, .how = detect_config_of(c), .size = m->image_size,
                             .epochs = c->optim.epochs, .seed = (uint64_t)c->loop.seed, .count = r->train->count };
    r->check_feed = (detect_feed){ .set = r->evaluation, .size = m->image_size };
    if (r->evaluation)
        r->check_feed.count = lt_min_i64(r->evaluation->count, c->loop.validate_samples);
    detect_groups(c, r->train->count, m->classes, r->group);
    return LT_OK;
}

/* ---- describing ------------------------------------------------------------------------------------------- */

static void describe_set(const task_run *r, const char *what, const detection_set *s, train_progress *p)
{
    const char *summary = detection_summary(r->arena, s);

    progress_note(p, "%-13s%s%s, %s: %s", what, s->title, s->synthetic ? " (synthetic)" : "", s->root,
                  summary ? summary : "");
}

static void run_describe(const task_run *r, train_progress *p)
{
    const lt_optim_group *g = &r->group[1];

    describe_set(r, "data", r->train, p);
    if (r->evaluation)
        describe_set(r, "validation", r->evaluation, p);
    progress_note(p, "optimiser    %s, rate %g", g->kind == LT_SGD ? "SGD" : g->kind == LT_ADAM ? "Adam" : "AdamW",
                  g->schedule.lr);
}

static void run_facts(const task_run *r, cJSON *env)
{
    cJSON_AddStringToObject(env, "data", r->train->title);
    cJSON_AddBoolToObject(env, "synthetic_data", r->train->synthetic);
}

/* ---- batches ---------------------------------------------------------------------------------------------- */

static loader_source run_samples(const task_run *r)
{
    return detect_source(&r->feed);
}

static loader_source run_checked(const task_run *r)
{
    return detect_source(&r->check_feed);
}

static size_t run_sample_bytes(const task_run *r)
{
    const size_t side = (size_t)r->model->image_size;

    return side * side * 3 * sizeof(float) + (size_t)DETECT_MAX_OBJECTS * (size_t)picture_words((int)side) * 4;
}

/* The mean over the shards, which the trainer makes, times the whole batch: the sum over the shards of the loss times
 * their images. */
static lt_status record(const void *ctx, model_record *rec)
{
    const task_run *r = ctx;

    csp_seg_record(r->model, true, r->config->optim.batch, rec);
    return LT_OK;
}

static int parts(const void *ctx, int batch)
{
    return feed_parts(((const task_run *)ctx)->model, batch);
}

static double feed(const void *ctx, const lt_plan *p, const model_record *r, const void *batch, int first, int part,
                   int n)
{
    (void)ctx;
    return detect_batch_feed(p, r, batch, first, part, n);
}

static recipe run_recipe(const task_run *r, const task_phase *phase)
{
    (void)phase;
    return (recipe){ .ctx = r, .record = record, .parts = parts, .feed = feed };
}

static double batch_weight(const void *batch)
{
    return ((const detect_batch *)batch)->count;
}

static const char *run_sample_name(const task_run *r, const void *batch, int i)
{
    const detect_batch *b = batch;

    return i < b->count ? r->train->image[b->index[i]].name : NULL;
}

/* ---- scores ----------------------------------------------------------------------------------------------- */

static lt_status run_score(task_run *r, const compiled *c, const void *batch, records *out, bool *no_losses)
{
    const detect_batch *b = batch;
    lt_arena *scratch = lt_arena_new();
    lt_status st = scratch ? LT_OK : lt_error(LT_ENOMEM, "no memory to score");

    (void)no_losses;
    for (int i = 0; i < b->count && st == LT_OK; i++) {
        detect_found *found;
        int n;

        if (!b->there[i])
            continue;
        lt_arena_reset(scratch);
        st = detect_found_in(c, r->model, i, b->width[i], b->height[i], &detection_rules_scored, scratch, &found, &n);
        if (st == LT_OK)
            st = detect_record(r->evaluation, b->index[i], b->width[i], b->height[i], found, n, out);
    }
    lt_arena_free(scratch);
    return st;
}

static void run_measure(task_run *r, const records *all, double *out)
{
    detect_measure(r->evaluation, all, out);
}

/* ---- steps ------------------------------------------------------------------------------------------------ */

static task_phase run_phase(const task_run *r, int64_t step)
{
    const train_optim_config *o = &r->config->optim;

    (void)step;
    return (task_phase){ .batch = o->batch, .shards = o->shards, .groups = (1u << DETECT_GROUPS) - 1,
                         .until = lt_ceil_div(r->train->count, o->batch) * o->epochs };
}

static const lt_optim_group *run_groups(const task_run *r, int *n, lt_optim_average *average)
{
    *n = DETECT_GROUPS;
    *average = (lt_optim_average){ .decay = r->config->optim.ema_decay, .tau = 2000, .statistics = true };
    return r->group;
}

const task detect_task = {
    .name = "detect", .data_size = sizeof(detect_config), .data_keys = detect_keys, .metrics = detect_metrics,
    .open = run_open, .close = run_close, .build = run_build, .describe = run_describe,
    .facts = run_facts, .samples = run_samples, .checked = run_checked, .sample_bytes = run_sample_bytes,
    .recipe = run_recipe, .weight = batch_weight, .sample_name = run_sample_name, .score = run_score,
    .measure = run_measure, .phase = run_phase, .groups = run_groups, .evaluate = detect_evaluate_run,
    .scores = detect_metrics,
};
