/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A model for other programs. What is written is read back and compared before it gets its name.
 */
#ifndef EVAL_EXPORT_EXPORT_H
#define EVAL_EXPORT_EXPORT_H

#include "models/model.h"

enum { EXPORT_INPUTS = 16 };

/* What an output of the file may differ by, relative to its largest value: EXPORT_TOLERANCE, or as many times the
 * model's own rounding where that is more, but EXPORT_MOST at most. */
#define EXPORT_TOLERANCE 1e-4
#define EXPORT_ROUNDINGS 8
#define EXPORT_MOST 1e-2

/* How far an output of the file is from the model's, over all inputs */
typedef struct {
    const char *name;
    double absolute;                /* the largest difference */
    double relative;                /* that over the output's largest magnitude */
    double rounding;                /* relatively too: between two of our ways to compute it, equally right */
} export_difference;

typedef struct {
    export_difference output[MODEL_PORTS];
    int n_outputs;
    int operators;                  /* of the graph */
    int opset;
    size_t bytes;
    bool any_batch;
} export_report;

typedef struct {
    const model *m;
    const char *hand_name;          /* the hand that the model poses, for the metadata */
    int batch;                      /* images in a run; 0: any number */
    const char *samples;            /* where the inputs and the model's outputs go, as npz; NULL: nowhere */
} export_options;

/**
 * export_onnx - the model as one ONNX file, pre-processing in its metadata
 *
 * Reads the file back, runs it on our own ops with EXPORT_INPUTS drawn inputs beside the model, for an open
 * batch size with another one than it was written with, and fails when an output differs by more than rounding
 * explains; path is as it was then. Maps are drawn as pictures are, coarse and fine: on white noise the statistics of a
 * trained network fit nothing, and numbers grow until their rounding is all there is. The metadata's keys are in
 * docs/onnx.md.
 *
 * Errors: LT_ENUMERIC names the output that differs, with *report filled; LT_EINVAL: an op without an ONNX
 * form; 2 GB and more; those of lt_atomic_commit and lt_npz_write.
 */
lt_status export_onnx(const export_options *o, const char *path, export_report *report);

/**
 * export_weights - parameters and statistics alone, as safetensors, without what an optimiser remembers
 *
 * Metadata: "format" (palmar-weights), "model", "variant", "config" (JSON of the model's group), "hand". Read
 * back and compared bit by bit. Errors: those of lt_safetensors_write; LT_EIO when a bit differs.
 */
lt_status export_weights(const export_options *o, const char *path, export_report *report);

#endif
