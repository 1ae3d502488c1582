/* SPDX-License-Identifier: Apache-2.0 */
/* Clips are made in memory, all of them, and then written. */
#include "synth/actions/actions.h"

#include "data/action/windows.h"
#include "eval/metrics/speed_histogram.h"
#include "libtensor/base/parallel.h"
#include "libtensor/io/array/npy.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/json.h"
#include "synth/actions/clip.h"
#include "synth/preset.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    EACH = ACTIONS_SUBJECTS * ACTION_CLASSES,   /* clips of a repetition */
    MOST_CLIPS = 100000, AT_ONCE = 200,         /* the second is no part of the result */
    WINDOW = 30, WINDOWS = 25,
    BODY = 3 * CLIP_FRAMES * ACTION_BODY, HAND_OBJECT = 3 * CLIP_FRAMES * ACTION_HAND_OBJECT,
};

typedef struct {
    const synth_options *opt;
    lt_arena *arena;
    action_set set;                 /* what is made, as the reader would have it */
    float *body, *hand_object;
    uint8_t *valid;
    action_clip *clip;
    int64_t first;                  /* clip of those that are being made */
    synth_manifest manifest;
} run;

static lt_status report(const run *r, int64_t done) { return synth_tell(r->opt, "clips", "clips", done, r->set.n); }

/* ---- making ---- */

static lt_status prepare(run *r)
{
    const int64_t n = r->opt->clips ? r->opt->clips : EACH * ACTIONS_REPETITIONS;

    if (n < EACH || n > MOST_CLIPS || n % EACH)
        return lt_error(LT_EINVAL, "%lld clips: preset actions has 10 subjects and 10 actions: want 100, 200 .. %d",
                        (long long)n, MOST_CLIPS);
    r->body = lt_arena_array(r->arena, (size_t)n, BODY * sizeof(float));
    r->hand_object = lt_arena_array(r->arena, (size_t)n, HAND_OBJECT * sizeof(float));
    r->valid = lt_arena_array(r->arena, (size_t)n, CLIP_FRAMES);
    r->clip = lt_arena_array(r->arena, (size_t)n, sizeof(*r->clip));
    if (!r->body || !r->hand_object || !r->valid || !r->clip)
        return lt_error(LT_ENOMEM, "synth: no memory for %lld clips", (long long)n);
    r->set = (action_set){ .root = r->opt->out, .clip = r->clip, .n = n, .length = CLIP_FRAMES,
                           .subjects = ACTIONS_SUBJECTS, .body = r->body, .hand_object = r->hand_object,
                           .valid = r->valid, .synthetic = true, .difficulty = r->opt->difficulty };
    return LT_OK;
}

/* By subject, then class: a clip's numbers do not depend on how many repetitions there are. */
static void make_task(void *ctx, int64_t i)
{
    run *r = ctx;
    const int64_t at = r->first + i, repetitions = r->set.n / EACH;
    const clip_number number = { (int)(at / repetitions / ACTION_CLASSES), (int)(at / repetitions % ACTION_CLASSES),
                                 (int)(at % repetitions) };
    clip c = { .body = r->body + at * BODY, .hand_object = r->hand_object + at * HAND_OBJECT,
               .valid = r->valid + at * CLIP_FRAMES };

    clip_make(r->opt->seed, r->opt->difficulty, &number, &c);
    r->clip[at] = (action_clip){ NULL, number.cls, number.subject, c.frames, c.onset };
}

static lt_status make_clips(run *r)
{
    lt_status st = report(r, 0);

    for (r->first = 0; !st && r->first < r->set.n; r->first += AT_ONCE) {
        const int64_t n = lt_min_i64(AT_ONCE, r->set.n - r->first);

        lt_parallel_for(n, make_task, r);
        st = report(r, r->first + n);
    }
    return st;
}

/* ---- writing ---- */

static lt_status write_array(run *r, const char *name, const lt_array *a)
{
    const char *path = lt_path_join(r->arena, r->opt->out, name);
    const lt_status st = path ? lt_npy_write(path, a) : lt_error(LT_ENOMEM, "%s: no memory", name);

    return st ? st : synth_manifest_file(&r->manifest, r->opt->out, name);
}

static lt_status write_arrays(run *r)
{
    const int64_t n = r->set.n;
    const lt_array body = lt_array_make(LT_ELEM_F4, 5, (int64_t[]){ n, 3, CLIP_FRAMES, ACTION_BODY, 1 }, r->body);
    const lt_array hand_object = lt_array_make(LT_ELEM_F4, 5, (int64_t[]){ n, 3, CLIP_FRAMES, ACTION_HAND_OBJECT, 1 },
                                               r->hand_object);
    const lt_array valid = lt_array_make(LT_ELEM_U1, 2, (int64_t[]){ n, CLIP_FRAMES }, r->valid);
    lt_status st = write_array(r, "body.npy", &body);

    if (!st)
        st = write_array(r, "hand_object.npy", &hand_object);
    return st ? st : write_array(r, "valid.npy", &valid);
}

static void add_number(cJSON *list, double x)
{
    cJSON_AddItemToArray(list, cJSON_CreateNumber(x));
}

/* Names tell subject, class and repetition, as file names of clips do. */
static cJSON *labels_of(const run *r)
{
    cJSON *root = cJSON_CreateObject(), *names = cJSON_AddArrayToObject(root, "names");
    cJSON *labels = cJSON_AddArrayToObject(root, "labels");
    cJSON *subject, *onset, *frames;

    cJSON_AddItemToObject(root, "classes", cJSON_CreateStringArray(action_classes, ACTION_CLASSES));
    subject = cJSON_AddArrayToObject(root, "subject");
    onset = cJSON_AddArrayToObject(root, "onset");
    frames = cJSON_AddArrayToObject(root, "frames");
    for (int64_t i = 0; i < r->set.n; i++) {
        const action_clip *c = &r->clip[i];
        char name[64];

        snprintf(name, sizeof(name), "S%03dA%02dR%03lld", c->subject + 1, c->cls + 1,
                 (long long)(i % (r->set.n / EACH)) + 1);
        cJSON_AddItemToArray(names, cJSON_CreateString(name));
        add_number(labels, c->cls);
        add_number(subject, c->subject);
        add_number(onset, c->onset);
        add_number(frames, c->frames);
    }
    return root;
}

static lt_status write_labels(run *r)
{
    const char *path = lt_path_join(r->arena, r->opt->out, "label.json");
    cJSON *root = labels_of(r);
    const lt_status st = path && root ? lt_json_write(path, root) : lt_error(LT_ENOMEM, "label.json: no memory");

    cJSON_Delete(root);
    return st ? st : synth_manifest_file(&r->manifest, r->opt->out, "label.json");
}

/* ---- figures ---- */

/* A window's histogram to the means, or whether they find its class */
static bool meet(const run *r, const action_window *w, bool learn, speed_means *means)
{
    float body[3 * WINDOW * ACTION_BODY], hand_object[3 * WINDOW * ACTION_HAND_OBJECT], valid[WINDOW];
    const int cls = r->clip[w->clip].cls;
    double histogram[SPEED_FEATURES];

    action_window_read(&r->set, w, WINDOW, body, hand_object, valid);
    speed_histogram(body, WINDOW, histogram);
    if (learn)
        speed_means_add(means, cls, histogram);
    return !learn && speed_means_nearest(means, histogram) == cls;
}

static lt_status baseline(const run *r, double *right)
{
    action_window_options how = { .frames = WINDOW, .per_clip = WINDOWS, .held_out = -1 };
    speed_means means = { .n = { 0 } };
    const action_window *w;
    int64_t n, hits = 0;
    lt_status st = LT_OK;

    for (int side = 0; !st && side < 2; side++) {
        how.evaluation = side;
        st = action_windows(r->arena, &r->set, &how, &w, &n);
        for (int64_t i = 0; !st && i < n; i++)
            hits += meet(r, &w[i], !side, &means);
    }
    *right = st ? NAN : (double)hits / (double)n;
    return st;
}

static lt_status measure(const run *r, synth_figure figure[ACTIONS_FIGURES])
{
    int64_t frames = 0, with = 0, known = 0;
    double right;
    const lt_status st = baseline(r, &right);

    for (int64_t i = 0; i < r->set.n; i++) {
        frames += r->clip[i].frames;
        with += r->clip[i].cls >= ACTION_WITH_OBJECT ? r->clip[i].frames : 0;
        for (int k = 0; k < CLIP_FRAMES; k++)
            known += r->valid[i * CLIP_FRAMES + k];
    }
    figure[0] = (synth_figure){ "speed histograms: windows of the last subject that are right, share", right, 0.3, 1 };
    figure[1] = (synth_figure){ "frames a clip, mean", (double)frames / (double)r->set.n, 70, 80 };
    figure[2] = (synth_figure){ "hand and object known, share of the frames of classes with one",
                                (double)known / (double)with, 0.3, 0.7 };
    return st;
}

/* ---- the whole ---- */

static lt_status finish(run *r, synth_figure *figure)
{
    const synth_result result = { "clips", r->set.n, figure, ACTIONS_FIGURES, false };
    lt_status st = write_arrays(r);

    if (!st)
        st = write_labels(r);
    if (!st)
        st = measure(r, figure);
    return st ? st : synth_finish(&r->manifest, r->opt, NULL, &result);
}

lt_status synth_actions(const synth_options *options, synth_figure figures[SYNTH_FIGURES], int *n)
{
    run r = { .opt = options, .arena = lt_arena_new() };
    lt_status st;

    if (!r.arena)
        return lt_error(LT_ENOMEM, "synth: no memory");
    r.manifest = (synth_manifest){ .arena = r.arena, .layout = "skeletons", .axes = "x right, y down, z forward" };
    st = prepare(&r);
    if (!st)
        st = make_clips(&r);
    if (!st)
        st = finish(&r, figures);
    *n = ACTIONS_FIGURES;
    lt_arena_free(r.arena);
    return st;
}
