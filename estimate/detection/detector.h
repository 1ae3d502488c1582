/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A detector at work: pictures in, and what is in them out.
 */
#ifndef ESTIMATE_DETECTION_DETECTOR_H
#define ESTIMATE_DETECTION_DETECTOR_H

#include "estimate/detection/found.h"
#include "estimate/trained.h"

typedef struct {
    trained t;                      /* path, model */
    const char **name;              /* of t.m's classes, n of them */
    int n;
    compiled c;
} detector;

/**
 * detector_open - a run's folder, a checkpoint file, or another program's weights of the YOLOv8-seg layout, variant n
 *
 * Weights by themselves (.pt, .safetensors) see pictures at 640 pixels; their classes are called what the file calls
 * them, or as class_names_of has it. detector_close frees it, also after a failure. Errors: those of trained_open and
 * weights_init; LT_EINVAL: weights that lack some of the network's.
 */
lt_status detector_open(const char *path, detector *out);
void detector_close(detector *d);

/**
 * detector_run - what is found in a picture, the surest first, in its pixels, in the arena
 *
 *   rgb   (height, width, 3)
 *
 * Errors: LT_ENOMEM; LT_ENUMERIC: scores that are not finite.
 */
lt_status detector_run(detector *d, const uint8_t *rgb, int width, int height, const detection_rules *rules,
                       lt_arena *arena, detect_found **out, int *n);

#endif
