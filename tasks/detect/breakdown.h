/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a report shows of a detector beside its numbers: curves of precision, what is taken for what, and the pictures
 * that it does worst on.
 */
#ifndef TASKS_DETECT_BREAKDOWN_H
#define TASKS_DETECT_BREAKDOWN_H

#include "tasks/detect/scores.h"

/**
 * detect_breakdown_write - files into a folder
 *
 *   table.md         the metrics, and the average precision of each class
 *   curves.json      precision over recall of hands, people, objects and all classes, at IoU 0.50 and 0.75
 *   confusion.csv    a row for each class, and one for nothing; a column for what was found there, the last one: missed
 *   per-image.csv    what is wrong in each image
 *   pictures.png     the images with the most of it
 *
 * The last three are of findings with a score above 0.25, at IoU 0.5: each of them, the surest first, takes the object
 * of its class that it overlaps most, and then any. Pictures that cannot be read any more are left out. Errors:
 * LT_ENOMEM, those of writing.
 */
lt_status detect_breakdown_write(const detection_set *set, const records *all, const double value[DETECT_METRICS],
                                 const char *folder);

/* ---- between breakdown.c and worst.c ------------------------------------------------------------------------- */

enum { DETECT_NOBODY = -1, DETECT_UNSURE = -2, DETECT_IN_CROWD = -3 };

/* Of an image: which object each finding takes, or one of the above; which finding takes each object, DETECT_NOBODY: it
 * is missed, or a crowd */
typedef struct {
    int *object_of, *finder_of;
    int right, confused, missed, wrong;         /* wrong: where nothing is */
} detect_match;

/* detect_match_of - in the arena. LT_ENOMEM */
lt_status detect_match_of(lt_arena *arena, const records *all, int64_t i, detect_match *out);

/* detect_worst_write - the sheet. place (n): records, the worst first. Those of lt_png_write; LT_ENOMEM */
lt_status detect_worst_write(const detection_set *set, const records *all, const int64_t *place, int n,
                             const char *path);

#endif
