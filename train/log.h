/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a run writes down as it goes: log.jsonl, one object a line; metrics.csv, one line for each validation;
 * and both again as TensorBoard's events. All are flushed line by line; going on from a checkpoint cuts off what
 * came after it.
 */
#ifndef TRAIN_LOG_H
#define TRAIN_LOG_H

#include "estimate/metric.h"
#include "libtensor/base/arena.h"
#include "models/model.h"

#include <stdio.h>

enum { TRAIN_COUNTS = 4 };

typedef struct {
    const char *name;
    int64_t n;
} train_count;

/* One step. */
typedef struct {
    int64_t step, epoch;            /* step counts from 1, epoch from 0 */
    double loss;
    const char *part_name[MODEL_PORTS];
    double part[MODEL_PORTS];
    int n_parts;
    double lr, grad_norm;
    const char *phase;              /* NULL where there is one */
    train_count count[TRAIN_COUNTS];
    int n_counts;
    double ms;                      /* of the step, its data included */
    double img_per_s, seconds;      /* since the run began, or went on */
    const char *bad;                /* not NULL: the step was skipped for this tensor, which is not finite */
} train_step_record;

enum { TRAIN_METRICS = 8 };

/* One validation. Losses are NaN where the samples lack what they compare with, metrics where they lack a truth. */
typedef struct {
    int64_t step, epoch, samples;
    const metric *metric[TRAIN_METRICS];
    double value[TRAIN_METRICS];
    int n_metrics;
    double loss;
    const char *part_name[MODEL_PORTS];
    double part[MODEL_PORTS];
    int n_parts;
} train_validation;

typedef struct {
    FILE *log, *metrics, *events;
    double norm[101];               /* the last gradient norms */
    int n_norms;
} train_log;

/**
 * train_log_open - append to folder/log.jsonl and folder/metrics.csv, begin a file in folder/tb
 *
 * Lines of steps after `step`, and a torn last line, are cut off first; TensorBoard is told to forget such events.
 * End with train_log_close.
 */
lt_status train_log_open(lt_arena *arena, const char *folder, int64_t step, train_log *out);
void train_log_close(train_log *l);

/* train_log_step, train_log_validation - errors are found by train_log_flush */
void train_log_step(train_log *l, const train_step_record *r);
void train_log_validation(train_log *l, const train_validation *v);

/* train_log_flush - LT_ENOSPC or LT_EIO when a line could not be written */
lt_status train_log_flush(train_log *l);

/* train_log_spike - remember a gradient norm; how many times the median of the last 101 it is, when that is over
 * 100, else 0. Needs 10 norms before it says anything. */
double train_log_spike(train_log *l, double norm);

#endif
