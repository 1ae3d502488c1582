/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The scored runs in a folder, as claims and filled tables read them.
 */
#ifndef EVAL_TABLES_RUNS_H
#define EVAL_TABLES_RUNS_H

#include "libtensor/base/arena.h"
#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

struct cJSON;

typedef struct {
    const char *name;               /* of its folder */
    struct cJSON *scores, *config;  /* config: without variant and seed, which stand below */
    const char *variant;            /* borrowed from scores */
    double seed;
    int setting;                    /* the first run with the same config and samples */
} eval_run;

typedef struct {
    lt_arena *arena;
    eval_run *run;
    int n;
} eval_runs;

/**
 * eval_runs_read - the scored runs in a folder, by name
 *
 *   folder   holds folders of runs, each with config.json and, once `palmar eval` has been there, eval/scores.json;
 *            other entries are passed over. NULL: no runs
 *
 * Ends in eval_runs_free, which a failure needs too. Errors: the folder cannot be read, a file in it is damaged.
 */
lt_status eval_runs_read(const char *folder, eval_runs *out);
void eval_runs_free(eval_runs *r);

/* eval_runs_alike - whether two were scored on the same samples, whatever the models */
bool eval_runs_alike(const eval_run *a, const eval_run *b);

/* eval_text_of, eval_number_of - a member of an object; "" and NaN where there is none of the kind */
const char *eval_text_of(const struct cJSON *o, const char *key);
double eval_number_of(const struct cJSON *o, const char *key);
bool eval_flag_of(const struct cJSON *o, const char *key);

/* eval_run_row - what was measured of a predictor; NULL: the model, whose row is the first. NULL for none. */
const struct cJSON *eval_run_row(const eval_run *r, const char *predictor);

#ifdef __cplusplus
}
#endif
#endif
