/* SPDX-License-Identifier: Apache-2.0 */
/* Files of results as COCO takes them: a list of what was found, in any order. */
#ifndef TASKS_DETECT_RESULTS_H
#define TASKS_DETECT_RESULTS_H

#include "tasks/detect/scores.h"

/* What a file says of each image of a set */
typedef struct {
    detect_found *found;
    size_t n, room;
} detect_result;

/**
 * detect_results_read - results by image, in the file's order
 *
 *   out     (set->count) in the arena
 *
 * bbox is x, y, width, height; segmentation, where it is there, COCO's runs of the whole picture. Errors: LT_EFORMAT
 * with the place: not a list, an image or category that the set does not have, a number that is missing; LT_ENOMEM.
 */
lt_status detect_results_read(lt_arena *arena, const char *path, const detection_set *set, detect_result **out);

#endif
