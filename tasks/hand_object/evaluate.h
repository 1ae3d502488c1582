/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Scoring a model on a dataset's split: the papers' metrics, their tables with our rows beneath, files for
 * the official scorers. The zero predictor and the mean-pose predictor are scored beside it.
 */
#ifndef TASKS_HAND_OBJECT_EVALUATE_H
#define TASKS_HAND_OBJECT_EVALUATE_H

#include "estimate/estimator.h"
#include "eval/tables/rows.h"

typedef struct {
    const model *m;
    const dataset *data;            /* with ground truth: joints and vertices */
    const dataset *training;        /* what the mean-pose predictor is made from; NULL: no such row */
    const lt_hand_model *hand;
    const char *hand_name;          /* for the protocol: "embedded synthetic hand", a file's name */
    const char *checkpoint;         /* its name and step, for scores.json */
    int64_t step;
    bool bilinear;                  /* crops are sampled between pixels: data.bilinear */
    int batch;                      /* images at a time */
    int64_t limit;                  /* samples scored, spread evenly over the split; 0: all */
    double seconds_per_image;       /* latency of one image, for Table 5; 0: not measured */
    /* told how far it is; false: stop. May be NULL. */
    bool (*progress)(void *ctx, int64_t done, int64_t total);
    void *progress_ctx;
} evaluate_options;

/* What was measured of one predictor, in the order of scores.json. */
enum { EVALUATE_SCORES = 40 };
typedef struct {
    const char *label;
    eval_score score[EVALUATE_SCORES];
    int n;
} evaluate_summary;

enum { EVALUATE_MODEL, EVALUATE_MEAN_POSE, EVALUATE_ZERO, EVALUATE_ROWS };

typedef struct evaluation evaluation;

/**
 * evaluate - run the model over the split and score it
 *
 * Errors: a sample that cannot be read; ground truth that is missing (then only a submission can be
 * made); LT_ESTOPPED when progress said so.
 */
lt_status evaluate(const evaluate_options *o, evaluation **out);
void evaluation_free(evaluation *e);

/* evaluation_summary - row EVALUATE_MODEL and so on; label NULL where the row was not made */
evaluate_summary evaluation_summary(const evaluation *e, int row);

/* evaluate_key_at - the i-th key of what is measured, NULL past the last; evaluation_score - of a row, NaN where
 * it was not made or there was nothing to measure */
const char *evaluate_key_at(int i);
double evaluation_score(const evaluation *e, int row, const char *key);

/* evaluation_print - the tables of the model's paper, our rows beneath the paper's */
lt_status evaluation_print(const evaluation *e, FILE *f, eval_format format);

/* evaluation_json - everything as a value that the caller frees with cJSON_Delete */
struct cJSON *evaluation_json(const evaluation *e);

/**
 * evaluation_write - in folder: table.md, scores.json, scores.txt (HO3D's own 14 lines), and the model's errors in
 * per-sample.csv, per-joint.csv, per-object.csv, per-sequence.csv
 */
lt_status evaluation_write(const evaluation *e, const char *folder);

/**
 * evaluate_submission - the split's result file, as the dataset's official scorer takes it
 *
 * HO3D: pred.json or .zip: OpenGL axes, metres, MANO order, the order of evaluation.txt; no truth is needed. DexYCB, by
 * the file's ending: hand joints (.txt), object poses (.csv), hand detections (.json); see dexycb_files.h.
 */
lt_status evaluate_submission(const evaluate_options *o, const char *path);

#endif
