/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The claims ledger: what a paper's ablation says comes out ahead of what, and whether that held in our own runs.
 *
 * An ordering of two variants can be tried on any dataset, where an absolute figure needs the paper's own.
 */
#ifndef EVAL_TABLES_CLAIMS_H
#define EVAL_TABLES_CLAIMS_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

struct cJSON;

/* In the paper's table `better` comes out ahead of `worse` in the metric of scores.json. */
typedef struct {
    const char *source;             /* "HOCAT, Table 5" */
    const char *model, *better, *worse;
    const char *metric;             /* "pa_mpjpe_mm" */
    double paper_better, paper_worse;   /* which of them is larger says whether less or more is better */
} eval_claim;

/* eval_claim_at - the i-th of all claims, NULL past the last */
const eval_claim *eval_claim_at(int i);

typedef struct eval_claims eval_claims;

/**
 * eval_claims_read - the scored runs in a folder, paired by claim
 *
 *   folder   holds folders of runs, each with config.json and, once `palmar eval` has been there, eval/scores.json;
 *            other entries are passed over. NULL: no runs
 *
 * Two runs are a pair when they differ in nothing but the model's variant: same seed, same other settings, scored on
 * the same samples. Ends in eval_claims_free. Errors: the folder cannot be read, a file in it is damaged.
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
