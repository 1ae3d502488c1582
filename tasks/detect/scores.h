/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How good detections are: what is kept of each image, and the official numbers over all of them.
 */
#ifndef TASKS_DETECT_SCORES_H
#define TASKS_DETECT_SCORES_H

#include "data/detection/detection.h"
#include "eval/metrics/ap.h"
#include "train/records.h"
#include "vision/detection/detection.h"

enum { DETECT_METRICS = 8 };

/* detect_metrics - the keys; ends with NULL */
extern const char *const detect_metrics[DETECT_METRICS + 1];

/**
 * detect_record - compare what was found in image i of a set with what is there, and keep it
 *
 *   width, height   of the image
 *
 * Areas are kept as they were at 640 pixels of the longer side, so that small is small in pictures of any size. Errors:
 * those of detection_objects and detection_mask; LT_ENOMEM.
 */
lt_status detect_record(const detection_set *set, int64_t i, int width, int height, const detect_found *found, int n,
                        records *out);

/* All images as average precision is measured of them, by boxes and by masks */
typedef struct { ap_image *box, *mask; } detect_images;

/* detect_images_of - (all->n) of each, in the arena. LT_ENOMEM. */
lt_status detect_images_of(lt_arena *arena, const records *all, detect_images *out);

/* detect_measure - a value for each of detect_metrics; NaN where nothing counts. LT_ENOMEM. */
lt_status detect_measure(const detection_set *set, const records *all, double out[DETECT_METRICS]);

#endif
