/* SPDX-License-Identifier: Apache-2.0 */
/*
 * `palmar eval --pred`: scores of a result file, which any estimator may have written.
 */
#ifndef CLI_EVAL_FILE_H
#define CLI_EVAL_FILE_H

#include "libtensor/base/status.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    const char *pred;               /* HO3D's pred.json or pred.zip; DexYCB's text of hand joints, BOP's csv */
    const char *data;               /* the folder of HO3D or DexYCB, which has the truth */
    const char *split, *setup;      /* DexYCB's */
    const char *models;             /* of the objects; NULL: where the dataset has them */
    const char *hand;               /* as cli_hand_open takes it */
    const char *out;                /* HO3D: a folder for scores.txt; NULL: none */
    bool (*progress)(void *ctx, int64_t done, int64_t total);      /* false ends it; ctx is NULL */
} eval_file_options;

/**
 * eval_file - the scores on stdout; on stderr notes on the file, and the protocol that they were made by
 *
 * What the file is, is seen by how it begins.
 *
 * HO3D has the 14 lines of its own scorer, DexYCB those of its toolkit.
 *
 * Errors: a dataset that cannot be opened, a file that is none of theirs or does not fit the split.
 */
lt_status eval_file(const eval_file_options *o);

#endif
