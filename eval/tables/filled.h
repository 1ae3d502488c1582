/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The papers' tables with a row for each scored run in a folder.
 *
 * A run fills the tables that `palmar eval` filled when it was scored, with the same numbers. It fills other papers'
 * tables, too, where they have a column of a key that it was scored by: results on the same dataset, or on any when it
 * is synthetic, but no ablation of another model.
 *
 * What separates a run from the paper's row that it reproduces is told where both are of the same data alone: a real
 * dataset of the table's name (DexYCB: in its setup s0), the whole split.
 */
#ifndef EVAL_TABLES_FILLED_H
#define EVAL_TABLES_FILLED_H

#include "eval/tables/tables.h"

#ifdef __cplusplus
extern "C" {
#endif

struct cJSON;

typedef struct eval_filled eval_filled;

/* eval_filled_read - of the runs in a folder, see eval/tables/runs.h; ends in eval_filled_free. Errors: those of
 * eval_runs_read; no run there was scored. */
lt_status eval_filled_read(const char *folder, eval_filled **out);
void eval_filled_free(eval_filled *f);

/* eval_filled_print - the tables that have a row of ours. Errors: LT_ENOMEM. */
lt_status eval_filled_print(const eval_filled *f, FILE *out, eval_format format);

/* eval_filled_json - the same, an array, which the caller frees with cJSON_Delete; NULL without memory */
struct cJSON *eval_filled_json(const eval_filled *f);

#ifdef __cplusplus
}
#endif
#endif
