/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How long a model or a layer takes: latency of inference and of a training step, memory, a profile by
 * layer, and two instruction sets in turn.
 */
#ifndef EVAL_BENCH_BENCH_H
#define EVAL_BENCH_BENCH_H

#include "libtensor/kernels/kernels.h"
#include "models/model.h"

#include <stdio.h>

typedef struct {
    const model *m;                 /* initialised; a training step moves its weights */
    int copies;                     /* of a layer, that m's graph holds: times are one's, and training is
                                     * forward and backward without a step. 0: a model */
    bool alone;                     /* nothing else uses m's weights: inference may give their memory back */
    const lt_kernels *kernels;      /* to run with; NULL: those in use */
    int batch;
    bool int8;                      /* inference with 8-bit integers, calibrated on what is measured with */
    bool train;                     /* forward, backward and Adam instead of forward alone */
    int runs;                       /* timed runs wanted */
    double seconds;                 /* but stop after this long, with at least three */
} bench_options;

typedef struct {
    double median_ms, p5_ms, p95_ms, min_ms;
    int runs;
    double peak_rss_mb;             /* of the process so far */
    double fma_before, fma_after;   /* GFLOP/s of the machine, read around the runs */
    int64_t macs;                   /* multiply-adds of one forward run of the batch */
    size_t plan_bytes;
    double post_ms;                 /* of what comes behind the network (post.h, tracks.h); 0: not measured */
    const char *post;               /* what that is, "boxes and masks of 30 objects" */
} bench_result;

typedef struct bench bench;

/* bench_new - compiles the model and fills its inputs with numbers. Errors: no memory, a graph that cannot
 * be. */
lt_status bench_new(const bench_options *o, bench **out);
void bench_free(bench *b);

/* bench_run - warm up three times, then measure. Another process slows it down: look at fma_before. */
bench_result bench_run(bench *b);

enum { BENCH_ROUNDS = 5 };

/**
 * bench_compare - measure a and b in turn, BENCH_ROUNDS times, sharing out runs and seconds
 *
 * A round during which the FMA peak fell below 0.9 of the best reading is measured again, up to twice as
 * many times. out[0] and out[1] are of the round with the lowest median; min_ms is of all rounds.
 */
void bench_compare(bench *a, bench *b, bench_result out[2]);

/* bench_print_ratio - how many times faster a is than b: by medians and by minima; text, or a line of JSON */
void bench_print_ratio(const bench *a, const bench *b, const bench_result r[2], FILE *f, bool json);

/* bench_print - one Markdown row (heading first when asked for), or one line of JSON */
void bench_print(const bench *b, const bench_result *r, FILE *f, bool heading);
void bench_print_json(const bench *b, const bench_result *r, FILE *f);

/* bench_print_layers - with int8: which layers read integers; else nothing */
void bench_print_layers(const bench *b, FILE *f);

/* bench_profile - the mean of five more runs, step by step: time, GFLOP/s and share by op, then the slowest layers */
void bench_profile(bench *b, FILE *f);

#endif
