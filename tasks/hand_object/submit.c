/* SPDX-License-Identifier: Apache-2.0 */
/* Result files for the official scorers: what a model sees in a split, as HO3D's and DexYCB's toolkits take it. */
#include "data/ho3d/ho3d.h"
#include "data/kind.h"
#include "estimate/estimator.h"
#include "eval/scorers/dexycb_files.h"
#include "eval/scorers/ho3d/score.h"
#include "eval/scorers/ho3d/submission.h"
#include "libtensor/io/file.h"
#include "tasks/hand_object/each_batch.h"
#include "vision/crop.h"

typedef struct submission_job submission_job;

/* What the scorers of one kind of dataset take. */
typedef struct {
    const dataset_kind *kind;
    bool objects;                   /* has object poses */
    lt_status (*open)(const dataset *d, const char *path, void **file);
    lt_status (*add)(const submission_job *j, const hand_object_batch *b);
    lt_status (*close)(void *file);
    void (*abort)(void *file);
} result_format;

struct submission_job {
    const evaluate_options *o;
    const result_format *format;
    void *file;                     /* the format's */
    estimator *estimator;
    estimate *estimates;
    object_shape *shape;
};

/* ---- HO3D ---- */

static lt_status open_ho3d(const dataset *d, const char *path, void **file)
{
    ho3d_submission *s;
    lt_status st;

    if (!lt_ends_with(path, ".json") && !lt_ends_with(path, ".zip"))
        return lt_error(LT_EINVAL, "%s: HO3D's result file is a .json, or a .zip with it in it", path);
    st = ho3d_submission_open(path, d->count, &s);
    *file = st ? NULL : s;
    return st;
}

static lt_status add_ho3d(const submission_job *j, const hand_object_batch *b)
{
    float joints[LT_HAND_KEYPOINTS][3], vertices[LT_HAND_VERTICES][3];
    lt_status st = LT_OK;

    for (int s = 0; st == LT_OK && s < b->count; s++) {
        ho3d_joints_from_camera(j->estimates[s].joints[0], joints[0]);
        ho3d_vertices_from_camera(j->estimates[s].vertices[0], vertices[0]);
        st = ho3d_submission_add(j->file, joints[0], vertices[0]);
    }
    return st;
}

static lt_status close_ho3d(void *file) { return ho3d_submission_close(file); }
static void abort_ho3d(void *file) { ho3d_submission_abort(file); }

/* ---- DexYCB ---- */

static lt_status open_dexycb(const dataset *d, const char *path, void **file)
{
    dexycb_results *r;
    const lt_status st = dexycb_results_open(path, &r);

    (void)d;
    *file = st ? NULL : r;
    return st;
}

static lt_status add_dexycb(const submission_job *j, const hand_object_batch *b)
{
    for (int s = 0; s < b->count; s++) {
        const estimate *e = &j->estimates[s];
        const dexycb_result r = {
            .place = dexycb_place_of(j->o->data, b->index[s]), .mirrored = b->flags[s] & SAMPLE_MIRRORED,
            .width = DEXYCB_WIDTH, .camera = crop_whole_camera(b->affine + 6 * s, b->K + 9 * s), .joints = e->joints,
            .seconds = j->o->seconds_per_image > 0 ? j->o->seconds_per_image : -1, .has_object = e->object_inliers > 0,
            .object = e->object, .score = e->object_confidence,
        };
        dexycb_results_add(j->file, &r);
    }
    return LT_OK;
}

static lt_status close_dexycb(void *file) { return dexycb_results_close(file); }
static void abort_dexycb(void *file) { dexycb_results_abort(file); }

/* ---- either ---- */

static const result_format formats[] = {
    { &ho3d_kind, false, open_ho3d, add_ho3d, close_ho3d, abort_ho3d },
    { &dexycb_kind, true, open_dexycb, add_dexycb, close_dexycb, abort_dexycb },
};

static lt_status submit_batch(void *ctx, const hand_object_batch *b, int64_t done)
{
    const submission_job *j = ctx;
    const dataset *d = j->o->data;

    (void)done;
    for (int s = 0; s < b->count; s++)
        j->shape[s] = j->format->objects && b->object[s] >= 0 ? dataset_shape(&d->objects[b->object[s]], b->flags[s])
                                                              : (object_shape){ 0 };
    estimator_run(j->estimator, b, j->shape, j->estimates);
    return j->format->add(j, b);
}

static lt_status find_format(submission_job *j)
{
    const dataset *d = j->o->data;

    for (size_t i = 0; i < LT_COUNT(formats); i++)
        if (formats[i].kind == d->kind)
            j->format = &formats[i];
    return j->format ? LT_OK : lt_error(LT_EINVAL, "%s: is %s, whose scorers take no file of hands and objects",
                                        d->root, d->kind->title);
}

lt_status evaluate_submission(const evaluate_options *o, const char *path)
{
    lt_arena *arena = lt_arena_new();
    submission_job j = { .o = o };
    lt_status st = find_format(&j);

    if (arena) {
        j.estimates = lt_arena_array(arena, (size_t)o->batch, sizeof(*j.estimates));
        j.shape = lt_arena_array(arena, (size_t)o->batch, sizeof(*j.shape));
    }
    if (!j.estimates || !j.shape)
        st = lt_error(LT_ENOMEM, "no memory for a submission");
    if (st == LT_OK)
        st = estimator_new(o->m, o->batch, &j.estimator);
    if (st == LT_OK)
        st = j.format->open(o->data, path, &j.file);
    if (st == LT_OK)
        st = eval_each_batch(o, submit_batch, &j);
    if (st == LT_OK)
        st = j.format->close(j.file);
    else if (j.file)
        j.format->abort(j.file);
    estimator_free(j.estimator);
    lt_arena_free(arena);
    return st;
}
