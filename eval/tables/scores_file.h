/* SPDX-License-Identifier: Apache-2.0 */
/*
 * scores.json, what an evaluation leaves for programs, and for the tables of many runs (runs.h).
 */
#ifndef EVAL_TABLES_SCORES_FILE_H
#define EVAL_TABLES_SCORES_FILE_H

#include "libtensor/base/status.h"

struct cJSON;

/* scores_file_write - scores as scores.json into a folder; they are deleted. Errors: LT_EIO; LT_ENOMEM, also where
 * scores is NULL, as nothing could be made of them. */
lt_status scores_file_write(const char *folder, struct cJSON *scores);

#endif
