/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What measuring shares with printing and the profile.
 */
#ifndef EVAL_BENCH_INTERNAL_H
#define EVAL_BENCH_INTERNAL_H

#include "eval/bench/bench.h"

#include "estimate/int8/calibrate.h"
#include "libtensor/base/arena.h"
#include "libtensor/graph/plan.h"
#include "libtensor/optim/optim.h"

struct bench {
    bench_options o;
    model_record record;            /* of a part */
    lt_plan *plan;
    int parts;                      /* of a training step, as the trainer has them */
    lt_optim *optim;                /* of a training step */
    double *ms;                     /* one a run */
    bool draws;                     /* it has the outputs "image" and "instances": */
    double instances;
    uint32_t image_crc32;           /* of its elements' bytes */
    lt_arena *arena;                /* with int8: of layers */
    calibration layers;
};

#define BENCH_PEAK_MS 20.0          /* how long the machine's peak is looked for, milliseconds */

/* bench_run_once - a forward run; in training a step */
void bench_run_once(bench *b);

#endif
