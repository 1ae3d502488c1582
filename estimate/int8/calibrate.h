/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which layers of a model can read 8-bit integers, and how: made by looking at what goes into them.
 *
 * Source of the scale: Krishnamoorthi 2018, "Quantizing deep convolutional networks for efficient inference", section
 * 3 (weights by output channel, activations by tensor); the clipping is the one of least squared error.
 */
#ifndef ESTIMATE_INT8_CALIBRATE_H
#define ESTIMATE_INT8_CALIBRATE_H

#include "libtensor/graph/plan.h"
#include "models/model.h"

#include <stdio.h>

/* A layer's result with integers must differ from the exact one by less than a hundredth of its energy, 20 dB. */
static const double CALIBRATE_LEAST_DB = 20;

/* Fills the inputs of p, whose record is r, with one batch after the other, and calls run after each. */
typedef lt_status (*calibrate_walk)(void *ctx, const lt_plan *p, const model_record *r, void (*run)(void *run_ctx),
                                    void *run_ctx);

typedef struct {
    const model *m;                 /* its table is not looked at */
    int batch;
    calibrate_walk walk;            /* asked twice */
    void *ctx;
} calibrate_options;

/* What was seen of a layer that could read integers. */
typedef struct {
    const char *layer;
    lt_int8_range range;            /* scale 0: no usable number came in */
    double db;                      /* energy of its result over that of its error; infinite without an error */
    bool integers;                  /* it reads them, as db is high enough */
} calibrated_layer;

/* Everything in the arena. The layers are in the order in which they run. */
typedef struct {
    const calibrated_layer *layer;
    int n;
    lt_int8_table table;            /* of those that read integers */
} calibration;

/**
 * calibrate - run the model on what walk gives, twice
 *
 * First the ranges: the scale of a layer is that with which the numbers that came in lose least, squared and summed
 * over a histogram of their sizes, by rounding and by cutting off. Then each layer with integers beside the exact one,
 * on the same input. Results that are outputs of the model are not among the layers, they stay exact.
 *
 * Errors: no memory, a graph that cannot be, those of walk.
 */
lt_status calibrate(lt_arena *arena, const calibrate_options *o, calibration *out);

/* calibration_print - how many layers read integers, and those that do not, with the reason */
void calibration_print(const calibration *c, FILE *f);

#endif
