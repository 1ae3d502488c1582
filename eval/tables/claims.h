/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The claims ledger: what a paper's ablation says comes out ahead of what, and whether that held in our own runs.
 *
 * An ordering of two variants can be tried on any dataset, where an absolute figure needs the paper's own. The paper's
 * numbers stand in its tables alone: a claim names the table, two of its rows and the key of a column.
 */
#ifndef EVAL_TABLES_CLAIMS_H
#define EVAL_TABLES_CLAIMS_H

#include "estimate/metric.h"
#include "eval/tables/tables.h"
#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

struct cJSON;

typedef enum {
    EVAL_CLAIM_ORDER,       /* `better` comes out ahead of `worse` */
    EVAL_CLAIM_DROP,        /* a difference of differences: what is made harder costs `better` less than `worse` */
    EVAL_CLAIM_BASELINE,    /* `better` comes out ahead of `worse`, a baseline's row in scores.json of the same run */
} eval_claim_kind;

typedef struct {
    eval_claim_kind kind;
    const eval_table *table;
    char model[32];                 /* "hocat", of whose variants it is */
    const char *better, *worse;     /* variants; of a baseline, worse: its label */
    const char *harder;             /* of a drop: what the harder variant's name has behind, "-cj"; else NULL */
    const char *worse_row;          /* of the worse variant's run, in the place of its model's; else NULL */
    const metric *what;
    double paper_better, paper_worse;   /* of a drop: the two differences, of which the less is the better; NaN:
                                     * the paper does not say */
} eval_claim;

/* eval_claim_at - the i-th of all claims; false past the last */
bool eval_claim_at(int i, eval_claim *out);

typedef struct eval_claims eval_claims;

/**
 * eval_claims_read - the scored runs in a folder (see eval/tables/runs.h), paired by claim; NULL: no runs
 *
 * Two runs are a pair when they differ in nothing but the model's variant: same seed, same other settings, scored on
 * the same samples. A drop takes four such runs, a baseline stands in the run itself. Ends in eval_claims_free. Errors:
 * those of eval_runs_read.
 */
lt_status eval_claims_read(const char *folder, eval_claims **out);
void eval_claims_free(eval_claims *c);

/* eval_claims_print - a Markdown table: each claim, on which data, with how many seeds, by which margin */
void eval_claims_print(const eval_claims *c, FILE *f);

/* eval_claims_json - the same as a value that the caller frees with cJSON_Delete; NULL without memory */
struct cJSON *eval_claims_json(const eval_claims *c);

#ifdef __cplusplus
}
#endif
#endif
