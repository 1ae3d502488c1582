/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What an evaluation leaves: scores.json for programs and for the tables of many runs (runs.h), table.md for people and
 * for palmar report.
 */
#ifndef EVAL_TABLES_SCORES_FILE_H
#define EVAL_TABLES_SCORES_FILE_H

#include "libtensor/io/atomic_file.h"

struct cJSON;

/* scores_file_write - scores as scores.json into a folder; they are deleted. Errors: LT_EIO; LT_ENOMEM, also where
 * scores is NULL, as nothing could be made of them. */
lt_status scores_file_write(const char *folder, struct cJSON *scores);

/* scores_table_open - begin table.md in a folder, as lt_atomic_open: Markdown of headings, paragraphs and tables.
 * LT_ENOMEM too. */
lt_status scores_table_open(const char *folder, lt_atomic_file *f);

#endif
