/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A trained hand-object model as a checkpoint for inference with 8-bit integers, and what they cost and gain.
 */
#ifndef TASKS_HAND_OBJECT_INT8_H
#define TASKS_HAND_OBJECT_INT8_H

#include "estimate/int8/calibrate.h"
#include "tasks/hand_object/evaluate.h"

typedef struct {
    model *m;                       /* loaded from the checkpoint `from`; gets the table */
    const char *from;
    bool bilinear;                  /* evaluate_options.bilinear */
    const dataset *calibration;     /* the training split */
    const dataset *scored;          /* the evaluation split, with ground truth; NULL: nothing is scored */
    const lt_hand_model *hand;
    const char *hand_name;
    int64_t samples;                /* calibrated on, spread evenly over the split */
    int64_t limit;                  /* scored at most, likewise */
    /* told how far it is; false: stop. May be NULL. */
    bool (*progress)(void *ctx, int64_t done, int64_t total);
    void *progress_ctx;
} export_int8_options;

/* The exact model's figures at place 0, those with integers at 1. */
typedef struct {
    calibration layers;             /* in the arena */
    size_t bytes;
    int64_t scored;                 /* samples; 0: not scored */
    double pa_mpjpe_mm[2];
    double ms[2];                   /* median of one image */
} export_int8_report;

/**
 * export_int8 - calibrate, write the checkpoint to path, read it back, and measure
 *
 * The file is a checkpoint in all but the optimiser: weights as floats, and the table in its metadata. With what is
 * read back the model is scored and timed beside the exact one. When only that fails the status is that of the
 * failure, and path is there.
 *
 * Errors: those of calibrate, checkpoint_save_inference, evaluate, and of samples that cannot be read.
 */
lt_status export_int8(lt_arena *arena, const export_int8_options *o, const char *path, export_int8_report *report);

#endif
