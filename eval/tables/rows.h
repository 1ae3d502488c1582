/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From scores to rows of the papers' tables.
 */
#ifndef EVAL_TABLES_ROWS_H
#define EVAL_TABLES_ROWS_H

#include "eval/metrics/curve.h"
#include "eval/metrics/metrics.h"
#include "eval/scorers/dexycb_score.h"
#include "eval/scorers/ho3d_score.h"
#include "eval/tables/tables.h"

#ifdef __cplusplus
extern "C" {
#endif

/* eval_row_ho3d - the first four columns of the HO3D hand tables (hocat-1, hocat-5, unified-4):
 * joints and vertices after Procrustes in mm, F at 5 and 15 mm after it in % */
void eval_row_ho3d(eval_row *row, const double scores[HO3D_SCORES]);

/* eval_row_dexycb - the first two columns of the DexYCB hand tables (hocat-3, unified-5,
 * unified-8) in mm: wrist on wrist, and after Procrustes of this kind (the table's) */
void eval_row_dexycb(eval_row *row, const double scores[DEXYCB_SCORES], eval_procrustes_kind kind);

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
