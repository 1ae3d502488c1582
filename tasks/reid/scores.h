/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The official numbers of trackers on the sequences of a split.
 */
#ifndef TASKS_REID_SCORES_H
#define TASKS_REID_SCORES_H

#include "data/mot/mot.h"
#include "eval/metrics/track.h"

#include <stdio.h>

enum { TRACK_SCORE_ROWS = 4 };

/* track_score_keys - hota, deta, assa, mota, idf1, switches, switches_unlike; ends with NULL */
extern const char *const track_score_keys[];

typedef struct {
    const char *name;               /* of the tracker */
    track_counts counts;
} track_score_row;

typedef struct {
    track_score_row row[TRACK_SCORE_ROWS];      /* the first is what is reported */
    int n, sequences;
    bool synthetic;
} track_score_table;

/* track_score_json - keys of the first row, and rows; for cJSON_Delete, NULL without memory. track_score_print - a
 * table in text. track_score_page - the same in Markdown, table.md in a folder, for palmar report */
struct cJSON *track_score_json(const track_score_table *t);
void track_score_print(const track_score_table *t, FILE *f);
lt_status track_score_page(const track_score_table *t, const char *folder);

/**
 * track_score_files - score a folder of results: SEQUENCE.txt for each of the split, in it or in its folder data
 *
 *   name     of the row
 *
 * Errors: those of mot_open, mot_read and mot_count; a sequence without truth or results; LT_ESTOPPED.
 */
lt_status track_score_files(const char *data, const char *split, const char *folder,
                            bool (*progress)(void *ctx, int64_t done, int64_t total), track_score_table *out);

#endif
