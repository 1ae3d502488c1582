/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hand_object/mean_labels.h"

#include <string.h>

enum { SAMPLES = 400 };             /* spread over the split: a mean needs no more */

typedef struct {
    float (*joints)[LT_HAND_KEYPOINTS][3], (*rotation)[LT_HAND_JOINTS][9], (*beta)[LT_HAND_BETAS];
    float (*R)[9], (*t)[3];
    int32_t *object;
} label_arrays;

/* *n counts those that were read. */
static lt_status read_label(const dataset *d, int64_t index, label_arrays *a, int64_t *n)
{
    const unsigned hand = SAMPLE_JOINTS | SAMPLE_HAND_POSE;
    lt_arena *arena = lt_arena_new();
    dataset_sample s;
    lt_status st = arena ? dataset_annotation(d, index, arena, &s) : lt_error(LT_ENOMEM, "no memory for a sample");

    if (st == LT_OK && (s.flags & hand) == hand) {
        const int64_t i = (*n)++;

        memcpy(a->joints[i], s.joints, sizeof(s.joints));
        memcpy(a->rotation[i], s.rotation, sizeof(s.rotation));
        memcpy(a->beta[i], s.beta, sizeof(s.beta));
        memcpy(a->R[i], s.R, sizeof(s.R));
        memcpy(a->t[i], s.t, sizeof(s.t));
        a->object[i] = s.object;
    }
    lt_arena_free(arena);
    return st == LT_ENOMEM ? st : LT_OK;
}

static lt_status fit(lt_arena *arena, const dataset *d, const lt_hand_model *hand, const int tips[5],
                     mean_predictor *out, bool *found)
{
    const int64_t n = lt_min_i64(SAMPLES, d->count);
    int64_t read = 0;
    label_arrays a = {
        lt_arena_array(arena, (size_t)n, sizeof(*a.joints)), lt_arena_array(arena, (size_t)n, sizeof(*a.rotation)),
        lt_arena_array(arena, (size_t)n, sizeof(*a.beta)), lt_arena_array(arena, (size_t)n, sizeof(*a.R)),
        lt_arena_array(arena, (size_t)n, sizeof(*a.t)), lt_arena_array(arena, (size_t)n, sizeof(*a.object)),
    };
    predictor_labels labels;
    lt_status st = LT_OK;

    if (!a.joints || !a.rotation || !a.beta || !a.R || !a.t || !a.object)
        return lt_error(LT_ENOMEM, "no memory for the training labels");
    for (int64_t i = 0; st == LT_OK && i < n; i++)
        st = read_label(d, i * d->count / n, &a, &read);
    *found = st == LT_OK && read;
    if (!*found)
        return st;
    labels = (predictor_labels){
        .n = read, .joints = a.joints[0][0], .rotation = a.rotation[0][0], .beta = a.beta[0],
        .object = a.object, .R = a.R[0], .t = a.t[0],
    };
    return mean_predictor_fit(&labels, hand, tips, out);
}

lt_status mean_labels_fit(const dataset *d, const lt_hand_model *hand, const int tips[5], mean_predictor *out,
                          bool *found)
{
    lt_arena *arena = lt_arena_new();
    const lt_status st = arena ? fit(arena, d, hand, tips, out, found)
                               : lt_error(LT_ENOMEM, "no memory for the training labels");

    lt_arena_free(arena);
    return st;
}
