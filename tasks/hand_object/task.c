/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The task of models that look at a crop with one hand and one object: what the trainer asks of it.
 */
#include "tasks/hand_object/task.h"

#include "estimate/feed.h"
#include "eval/metrics/metrics.h"
#include "libtensor/io/file.h"
#include "tasks/hand_object/mean_labels.h"
#include "tasks/hand_object/source.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

struct task_run {
    lt_arena *arena;                /* the run's */
    run_source source;
    model *model;
    double pa_mpjpe_mm;             /* of the last validation; 0: none was made */
};

/* ---- opening ---------------------------------------------------------------------------------------------- */

/* So that the run's config finds the same data and hands from any folder, and whatever $PALMAR_HAND says then */
static lt_status keep_paths(const task_run *r, train_config *c)
{
    hand_object_config *d = (hand_object_config *)c->data;

    d->hand = r->source.hands.path;
    d->common.dir = lt_path_whole(r->arena, d->common.dir);
    if (*d->objects)
        d->objects = lt_path_whole(r->arena, d->objects);
    if (*d->hand_left)
        d->hand_left = lt_path_whole(r->arena, d->hand_left);
    return d->common.dir && d->objects && d->hand_left ? LT_OK : lt_error(LT_ENOMEM, "no memory to begin");
}

static lt_status run_open(lt_arena *arena, train_config *c, task_run **out)
{
    task_run *r = lt_arena_alloc(arena, sizeof(*r));
    lt_status st;

    *out = r;
    if (!r)
        return lt_error(LT_ENOMEM, "no memory to begin");
    r->arena = arena;
    st = source_open(arena, c, &r->source);
    return st ? st : keep_paths(r, c);
}

static void run_close(task_run *r)
{
    source_close(&r->source);
}

static lt_status run_build(task_run *r, const train_config *c, lt_params *set, model *out)
{
    const lt_status st = train_config_model(c, r->source.layer, set, out);

    if (st == LT_OK) {
        r->model = out;
        source_sizes(&r->source, out);
    }
    return st;
}

/* ---- telling ---------------------------------------------------------------------------------------------- */

static void run_describe(const task_run *r, train_progress *p)
{
    const run_source *s = &r->source;
    const int *tips = s->train->tips;

    progress_note(p, "data         %s%s, %s: %" PRId64 " to train on, %" PRId64 " %s%s to validate",
                  s->train->title, s->train->synthetic ? " (synthetic)" : "", s->train->root, s->train_count,
                  s->check_count, s->evaluation ? "of " : "held back", s->evaluation ? s->evaluation->split : "");
    if (s->train->partial)
        progress_note(p, "             %s", s->train->partial);
    if (s->evaluation && s->evaluation->partial)
        progress_note(p, "             %s", s->evaluation->partial);
    progress_note(p, "hand         %s%s, finger tips (vertices %d %d %d %d %d) %.2f mm from the annotated",
                  s->hands.name, s->hand->synthetic && !hands_are_embedded(&s->hands) ? " (synthetic)" : "",
                  tips[0], tips[1], tips[2], tips[3], tips[4], s->tips_rms_mm);
    if (hands_are_embedded(&s->hands))
        progress_note(p, "             %s", hands_note());
}

static void run_facts(const task_run *r, cJSON *env)
{
    cJSON_AddStringToObject(env, "data", r->source.train->title);
    cJSON_AddBoolToObject(env, "synthetic_data", r->source.train->synthetic);
    cJSON_AddBoolToObject(env, "synthetic_hand", r->source.hand->synthetic);
}

/* ---- batches ---------------------------------------------------------------------------------------------- */

static loader_source run_samples(const task_run *r)
{
    return source_loader(&r->source);
}

static loader_source run_checked(const task_run *r)
{
    return source_checker(&r->source);
}

static size_t run_sample_bytes(const task_run *r)
{
    const size_t side = (size_t)r->model->image_size;

    return side * side * 4 * sizeof(float);
}

static recipe run_recipe(const task_run *r, const task_phase *phase)
{
    (void)phase;
    return feed_recipe(r->model);
}

static double batch_weight(const void *batch)
{
    const hand_object_batch *b = batch;
    double sum = 0;

    for (int i = 0; i < b->count; i++)
        sum += b->weight[i];
    return sum;
}

static const char *run_sample_name(const task_run *r, const void *batch, int i)
{
    const hand_object_batch *b = batch;

    return i < b->count ? dataset_name(r->source.train, b->index[i]) : NULL;
}

/* ---- validation: joint errors. The papers' tables are evaluate.h's; this is for choosing a checkpoint ---------- */

enum { J = LT_HAND_KEYPOINTS };

/* NaN without joints to compare */
typedef struct { double pa, mpjpe; } joint_errors;

static joint_errors compare_joints(const lt_real *predicted, const float *truth)
{
    double p[3 * J], g[3 * J], aligned[3 * J];
    joint_errors e;

    for (int i = 0; i < 3 * J; i++)
        p[i] = predicted[i];
    eval_widen(3 * J, truth, g);
    eval_align_root(J, p, g, 0, aligned);
    e.mpjpe = eval_mpjpe(J, aligned, g);
    eval_align_procrustes(EVAL_REFLECT, J, p, g, aligned);
    e.pa = eval_mpjpe(J, aligned, g);
    return e;
}

static lt_status run_score(task_run *r, const compiled *c, const void *batch, records *out, bool *no_losses)
{
    const hand_object_batch *b = batch;
    const lt_real *joints = compiled_output(c, "joints");
    lt_status st = LT_OK;

    (void)r;
    for (int i = 0; st == LT_OK && i < b->count; i++) {
        joint_errors e = { NAN, NAN };

        if (!(b->weight[i] > 0))
            continue;
        if (joints && (b->flags[i] & SAMPLE_JOINTS))
            e = compare_joints(joints + 3 * J * i, b->joints + 3 * J * i);
        *no_losses |= !(b->flags[i] & SAMPLE_HAND_POSE);
        st = records_add(out, b->index[i], &e, sizeof(e));
    }
    return st;
}

static const char *const metrics[] = { "pa_mpjpe_mm", "mpjpe_mm", NULL };

static void run_measure(task_run *r, const records *all, double *out)
{
    double pa = 0, mpjpe = 0;
    int64_t n = 0;

    for (int64_t i = 0; i < all->n; i++) {
        joint_errors e;

        memcpy(&e, records_at(all, i, NULL), sizeof(e));
        if (isnan(e.pa))
            continue;
        pa += e.pa;
        mpjpe += e.mpjpe;
        n++;
    }
    out[0] = n ? 1000 * (pa / (double)n) : NAN;
    out[1] = n ? 1000 * (mpjpe / (double)n) : NAN;
    r->pa_mpjpe_mm = out[0];
}

/* PA-MPJPE of one pose for all the samples that validation looks at; NaN where none has joints. */
static double error_of(const run_source *s, const float *joints)
{
    lt_real pose[3 * J];
    double sum = 0;
    int64_t n = 0;

    for (int i = 0; i < 3 * J; i++)
        pose[i] = joints[i];
    for (int64_t i = 0; i < s->check_count; i++) {
        lt_arena *arena = lt_arena_new();
        dataset_sample truth;

        if (arena && dataset_annotation(s->check_feed.data, s->check_first + i, arena, &truth) == LT_OK &&
            (truth.flags & SAMPLE_JOINTS)) {
            sum += compare_joints(pose, truth.joints[0]).pa;
            n++;
        }
        lt_arena_free(arena);
    }
    return n ? 1000 * (sum / (double)n) : NAN;
}

/* A model that is no better than a pose that sees no image has learnt nothing that the labels' mean does not say. Not
 * knowing that pose is no fault of the run. */
static void run_conclude(task_run *r, train_progress *p)
{
    const run_source *s = &r->source;
    mean_predictor mean;
    bool found = false;
    double error;

    if (!(r->pa_mpjpe_mm > 0) || mean_labels_fit(s->train, s->hand, s->train->tips, &mean, &found) || !found)
        return;
    error = error_of(s, mean.joints[0]);
    if (r->pa_mpjpe_mm >= error)
        progress_warn(p, "the hand is no better than the mean of the training labels: PA-MPJPE %.1f mm, the mean "
                      "pose's %.1f; train for longer, or on more", r->pa_mpjpe_mm, error);
}

const task hand_object_task = {
    .name = "hand-object", .data_size = sizeof(hand_object_config), .data_keys = hand_object_keys, .metrics = metrics,
    .open = run_open, .close = run_close, .build = run_build, .describe = run_describe, .facts = run_facts,
    .samples = run_samples, .checked = run_checked, .sample_bytes = run_sample_bytes, .recipe = run_recipe,
    .weight = batch_weight, .sample_name = run_sample_name, .score = run_score, .measure = run_measure,
    .conclude = run_conclude,
};
