/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/action/evaluate.h"

#include "estimate/checkpoint/checkpoint.h"
#include "eval/metrics/speed_histogram.h"
#include "eval/tables/scores_file.h"
#include "models/action/action.h"
#include "tasks/action/batch.h"
#include "tasks/action/clips.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

enum { BATCH = 16 };

typedef struct {
    const task_evaluation *e;
    model m;
    action_set set;
    const action_window *window;
    int64_t n, done, total;
    action_confusion *to;
    action_scores scores;
} evaluating;

int action_find(const lt_real *logits)
{
    int found = 0;

    for (int i = 1; i < ACTION_CLASSES; i++)
        found = logits[i] > logits[found] ? i : found;
    return found;
}

static lt_status record(const void *ctx, model_record *r)
{
    ((const model *)ctx)->cls->record(ctx, false, r);
    return LT_OK;
}

static double feed(const void *ctx, const lt_plan *p, const model_record *r, const void *batch, int first, int part,
                   int n)
{
    (void)ctx, (void)part, (void)n;
    return action_batch_feed(p, r, batch, first);
}

static lt_status visit(void *ctx, const compiled *c, const void *batch)
{
    evaluating *v = ctx;
    const action_batch *b = batch;
    const lt_real *logits = compiled_output(c, "logits");

    for (int i = 0; i < b->count; i++)
        action_confusion_add(v->to, b->cls[i], action_find(logits + i * ACTION_OUTPUTS));
    v->done += b->count;
    return !v->e->progress || v->e->progress(v->e->ctx, v->done, v->total) ? LT_OK : lt_error(LT_ESTOPPED, "stopped");
}

/* All windows with these streams */
static lt_status score(evaluating *v, const compiled *c, action_streams streams, action_confusion *to)
{
    const action_data_config *d = action_data_of(v->e->config);
    const action_feed from = { .set = &v->set, .window = v->window, .count = v->n, .T = action_frames(&v->m),
                               .min_valid = d->min_valid, .streams = streams };
    const loader_source source = action_source(&from);

    v->to = to;
    return compiled_walk(c, &source, d->common.threads, 0, visit, NULL, v, NULL);
}

static lt_status score_all(evaluating *v)
{
    const action_streams streams = (action_streams)action_data_of(v->e->config)->streams;
    const recipe by = { .ctx = &v->m, .record = record, .feed = feed };
    compiled c;
    lt_status st = compiled_new(&by, BATCH, false, &c);

    if (st)
        return st;
    v->total = 3 * v->n;
    st = score(v, &c, streams, &v->scores.both);
    if (!st)
        st = score(v, &c, STREAMS_BODY, &v->scores.body_only);
    if (!st)
        st = score(v, &c, STREAMS_HAND_OBJECT, &v->scores.hand_object_only);
    compiled_free(&c);
    return st;
}

/* ---- the baseline: it learns from the side that is trained on ---- */

typedef struct {
    speed_means means;
    int64_t right;
    float *body, *hand_object, *valid;
} baseline;

static void look_at(const evaluating *v, const action_window *w, bool learn, baseline *b)
{
    const int T = action_frames(&v->m), cls = v->set.clip[w->clip].cls;
    double histogram[SPEED_FEATURES];

    action_window_read(&v->set, w, T, b->body, b->hand_object, b->valid);
    speed_histogram(b->body, T, histogram);
    if (learn)
        speed_means_add(&b->means, cls, histogram);
    else
        b->right += speed_means_nearest(&b->means, histogram) == cls;
}

static lt_status score_baseline(evaluating *v)
{
    const size_t T = (size_t)action_frames(&v->m);
    const action_window_options how = action_windows_of(v->e->config, (int)T, false);
    const action_window *learnt;
    int64_t n;
    baseline *b = lt_arena_alloc(v->e->arena, sizeof(*b));
    lt_status st = action_windows(v->e->arena, &v->set, &how, &learnt, &n);

    if (st)
        return st;
    if (b)
        *b = (baseline){ .body = lt_arena_array(v->e->arena, T * 3 * ACTION_BODY, sizeof(float)),
                         .hand_object = lt_arena_array(v->e->arena, T * 3 * ACTION_HAND_OBJECT, sizeof(float)),
                         .valid = lt_arena_array(v->e->arena, T, sizeof(float)) };
    if (!b || !b->body || !b->hand_object || !b->valid)
        return lt_error(LT_ENOMEM, "no memory for the baseline");
    for (int64_t i = 0; i < n; i++)
        look_at(v, &learnt[i], true, b);
    for (int64_t i = 0; i < v->n; i++)
        look_at(v, &v->window[i], false, b);
    v->scores.baseline = (double)b->right / (double)v->n;
    return LT_OK;
}

/* ---- the whole ---- */

/* Every so many windows, where there is a limit */
static void spread(evaluating *v)
{
    action_window *kept = (action_window *)v->window;
    const int64_t n = v->e->limit ? lt_min_i64(v->e->limit, v->n) : v->n;

    for (int64_t i = 0; i < n; i++)
        kept[i] = v->window[i * v->n / n];
    v->n = n;
}

static lt_status open_windows(evaluating *v)
{
    const train_config *c = v->e->config;
    const bool evaluation = strcmp(v->e->split, "train") != 0;
    const action_window_options how = action_windows_of(c, action_frames(&v->m), evaluation);
    lt_status st = action_clips_open(v->e->arena, c, &v->set);

    if (!st)
        st = action_windows(v->e->arena, &v->set, &how, &v->window, &v->n);
    if (st)
        return st;
    spread(v);
    v->scores.split = how.split == ACTION_BY_SUBJECT ? "subject" : "random";
    v->scores.synthetic = v->set.synthetic;
    v->scores.difficulty = v->set.difficulty;
    return LT_OK;
}

lt_status action_evaluate_run(const task_evaluation *e, cJSON **scores)
{
    evaluating v = { .e = e };
    lt_params *set = lt_params_new();
    lt_status st = set ? train_config_model(e->config, NULL, set, &v.m)
                       : lt_error(LT_ENOMEM, "no memory for the model");

    if (!st)
        st = checkpoint_load_model(e->checkpoint, &v.m);
    if (!st)
        st = open_windows(&v);
    if (!st)
        st = score_all(&v);
    v.scores.baseline = NAN;
    if (!st && !v.set.whole)
        st = score_baseline(&v);
    lt_params_free(set);
    if (!st)
        st = action_scores_page(&v.scores, e->folder);
    if (!st)
        st = scores_file_write(e->folder, action_scores_json(&v.scores));
    if (st)
        return st;
    if (e->tables)
        action_scores_print(&v.scores, e->tables);
    *scores = action_scores_json(&v.scores);
    return *scores ? LT_OK : lt_error(LT_ENOMEM, "no memory for the scores");
}
