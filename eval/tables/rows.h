/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From scores to rows of the papers' tables.
 */
#ifndef EVAL_TABLES_ROWS_H
#define EVAL_TABLES_ROWS_H

#include "eval/metrics/curve.h"
#include "eval/tables/tables.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What was measured of one predictor in one metric of the dictionary, in its unit. */
typedef struct {
    const char *key;
    double value;                   /* not finite: a prediction failed */
    bool missing;                   /* there was nothing to measure */
} eval_score;

/* eval_row_fill - the columns whose keys are among n scores; columns about one object are eval_row_objects' */
void eval_row_fill(const eval_table *t, eval_row *row, const eval_score *scores, int n);

/* Shares of correct poses by object, for the tables with a column per object (hocat-2,
 * hocat-4). */
typedef struct {
    eval_share column[EVAL_COLUMNS];
    int64_t outside;                /* samples of objects that the table has no column for */
} eval_object_shares;

/* eval_object_shares_add - one sample: correct when error <= 0.1 diameter (same unit); model is
 * the name of the model's folder */
void eval_object_shares_add(const eval_table *t, eval_object_shares *s, const char *model,
                            double error, double diameter);

/* eval_row_objects - % per object and their plain mean in the column "average"; an object without
 * samples stays "-" and out of the mean */
void eval_row_objects(const eval_table *t, const eval_object_shares *s, eval_row *row);

#ifdef __cplusplus
}
#endif
#endif
