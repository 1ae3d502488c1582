/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The official numbers of a detector, or of a file of results, on a split of a dataset.
 */
#ifndef TASKS_DETECT_EVALUATE_H
#define TASKS_DETECT_EVALUATE_H

#include "models/model.h"
#include "tasks/detect/scores.h"
#include "train/task.h"

#include <stdio.h>

typedef struct {
    const char *data, *split;       /* as detection_open takes them */
    const model *m;                 /* a csp_seg, to score; or NULL, and */
    const char *pred;               /* a file of COCO's results: image_id, category_id, bbox, score, segmentation */
    const char *folder;             /* where scores.json and what detect_breakdown_write leaves go; NULL: nowhere */
    int batch, threads, limit;      /* images at a time; that prepare them; at most, the first, 0: all */
    bool (*progress)(void *ctx, int64_t done, int64_t total);   /* may be NULL; false: LT_ESTOPPED */
} detect_evaluation;

typedef struct {
    double value[DETECT_METRICS];   /* of detect_metrics; NaN: nothing counts */
    int64_t images;
    bool synthetic;
    const char *title;              /* of the dataset; a constant text */
} detect_scores;

/* detect_evaluate - errors: those of the dataset; a model of other classes; a file of results that is none, with its
 * place; LT_ESTOPPED */
lt_status detect_evaluate(const detect_evaluation *e, detect_scores *out);

/* detect_scores_json - an object by key, for cJSON_Delete; NULL without memory. detect_scores_print - a line each */
struct cJSON *detect_scores_json(const detect_scores *s);
void detect_scores_print(const detect_scores *s, FILE *f);

/* detect_evaluate_run - task.evaluate: of a run's model */
lt_status detect_evaluate_run(const task_evaluation *e, struct cJSON **scores);

#endif
