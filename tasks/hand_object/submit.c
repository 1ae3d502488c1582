/* SPDX-License-Identifier: Apache-2.0 */
/* Result files for the official scorers: what a model sees in a split, as HO3D's and DexYCB's toolkits take it. */
#include "estimate/estimator.h"
#include "eval/scorers/dexycb_files.h"
#include "eval/scorers/ho3d_score.h"
#include "eval/scorers/ho3d_submission.h"
#include "libtensor/io/file.h"
#include "tasks/hand_object/each_batch.h"
#include "vision/crop.h"

#include <string.h>

typedef struct {
    const evaluate_options *o;
    ho3d_submission *ho3d;
    dexycb_results *dexycb;         /* one of the two */
    estimator *estimator;
    estimate *estimates;
    const float (**control)[3];
} submission_job;

static lt_status add_ho3d(const submission_job *j, const hand_object_batch *b)
{
    float joints[LT_HAND_KEYPOINTS][3], vertices[LT_HAND_VERTICES][3];
    lt_status st = LT_OK;

    for (int s = 0; st == LT_OK && s < b->count; s++) {
        ho3d_joints_from_camera(j->estimates[s].joints[0], joints[0]);
        ho3d_vertices_from_camera(j->estimates[s].vertices[0], vertices[0]);
        st = ho3d_submission_add(j->ho3d, joints[0], vertices[0]);
    }
    return st;
}

static void add_dexycb(const submission_job *j, const hand_object_batch *b)
{
    for (int s = 0; s < b->count; s++) {
        const estimate *e = &j->estimates[s];
        const dexycb_result r = {
            .place = dexycb_place_of(j->o->data, b->index[s]), .mirrored = b->flags[s] & SAMPLE_MIRRORED,
            .width = DEXYCB_WIDTH, .camera = crop_whole_camera(b->affine + 6 * s, b->K + 9 * s), .joints = e->joints,
            .seconds = j->o->seconds_per_image > 0 ? j->o->seconds_per_image : -1, .has_object = e->object_inliers > 0,
            .object = e->object, .score = e->object_confidence,
        };
        dexycb_results_add(j->dexycb, &r);
    }
}

static lt_status submit_batch(void *ctx, const hand_object_batch *b, int64_t done)
{
    const submission_job *j = ctx;
    const dataset *d = j->o->data;

    (void)done;
    for (int s = 0; s < b->count; s++)
        j->control[s] = j->dexycb && b->object[s] >= 0 ? dataset_control(&d->objects[b->object[s]], b->flags[s]) : NULL;
    estimator_run(j->estimator, b, j->control, j->estimates);
    if (j->ho3d)
        return add_ho3d(j, b);
    add_dexycb(j, b);
    return LT_OK;
}

static lt_status open_file(submission_job *j, const char *path)
{
    if (dataset_is_dexycb(j->o->data))
        return dexycb_results_open(path, &j->dexycb);
    if (!lt_ends_with(path, ".json") && !lt_ends_with(path, ".zip"))
        return lt_error(LT_EINVAL, "%s: HO3D's result file is a .json, or a .zip with it in it", path);
    return ho3d_submission_open(path, j->o->data->count, &j->ho3d);
}

static lt_status end_file(submission_job *j, lt_status st)
{
    if (st) {
        ho3d_submission_abort(j->ho3d);
        dexycb_results_abort(j->dexycb);
        return st;
    }
    return j->ho3d ? ho3d_submission_close(j->ho3d) : dexycb_results_close(j->dexycb);
}

lt_status evaluate_submission(const evaluate_options *o, const char *path)
{
    lt_arena *arena = lt_arena_new();
    submission_job j = { .o = o };
    lt_status st = LT_OK;

    if (arena) {
        j.estimates = lt_arena_array(arena, (size_t)o->batch, sizeof(*j.estimates));
        j.control = lt_arena_array(arena, (size_t)o->batch, sizeof(*j.control));
    }
    if (!j.estimates || !j.control)
        st = lt_error(LT_ENOMEM, "no memory for a submission");
    if (st == LT_OK)
        st = estimator_new(o->m, o->batch, &j.estimator);
    if (st == LT_OK)
        st = open_file(&j, path);
    if (st == LT_OK)
        st = eval_each_batch(o, submit_batch, &j);
    st = j.ho3d || j.dexycb ? end_file(&j, st) : st;
    estimator_free(j.estimator);
    lt_arena_free(arena);
    return st;
}
