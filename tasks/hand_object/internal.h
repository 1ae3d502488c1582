/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What scoring leaves for reporting.
 */
#ifndef TASKS_HAND_OBJECT_INTERNAL_H
#define TASKS_HAND_OBJECT_INTERNAL_H

#include "estimate/protocol.h"
#include "eval/scorers/dexycb_score.h"
#include "eval/scorers/ho3d/score.h"
#include "eval/scorers/object_score.h"
#include "eval/tables/rows.h"
#include "tasks/hand_object/breakdown.h"
#include "tasks/hand_object/evaluate.h"
#include "tasks/hand_object/predictors.h"

enum { EVALUATE_OBJECT_TABLES = 4 };

typedef struct {
    const char *label;
    ho3d_scorer *ho3d;
    dexycb_scorer *dexycb;
    eval_object_shares shares[EVALUATE_OBJECT_TABLES];      /* of the tables by object */
    double *adds;                   /* (n_adds) ADD-S of each sample with an object, metres */
    int64_t n_adds;
    eval_share add01, rep5;
    eval_mean_of add, oce, mce, mean_adds;
    int64_t no_pose;
} score_set;

/* What one predictor says of a batch, and where its errors go. */
typedef struct {
    float (*joints)[LT_HAND_KEYPOINTS][3], (*vertices)[LT_HAND_VERTICES][3];   /* camera */
    float (*gl_joints)[LT_HAND_KEYPOINTS][3], (*gl_vertices)[LT_HAND_VERTICES][3];
    lt_pose *object;
    ho3d_sample_errors *hand_errors;
    dexycb_sample_errors *relative_errors;
    eval_object_errors *object_errors;
} batch_rows;

struct evaluation {
    evaluate_options o;
    lt_arena *arena;
    score_set set[EVALUATE_ROWS];
    mean_predictor mean;
    bool has_mean;
    eval_object *object;                        /* the dataset's, symmetric by HFL-Net's list */
    const eval_table *by_object[EVALUATE_OBJECT_TABLES];    /* of the model's tables; n_by_object of them */
    int n_by_object;
    int64_t samples;
    batch_rows rows, truth;
    object_shape *shape;
    estimate *estimates;
    lt_camera *camera;
    int32_t *which;
    uint32_t *flags;                            /* of sample_flag */
    double (*per_sample)[5];
    const char **names;
    eval_breakdown *breakdown;                  /* of the model's errors */
};

#endif
