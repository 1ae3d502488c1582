/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Trains a model: `palmar train` behind its options.
 */
#ifndef TRAIN_TRAINER_H
#define TRAIN_TRAINER_H

#include "train/log.h"
#include "train/ranks/ranks.h"
#include "train/task.h"

typedef struct {
    const task *const *tasks;       /* all that there are, NULL-terminated */
    const char *config;             /* JSON file or the folder of a run; NULL with resume: the run's own */
    const char *const *set;         /* overrides: "optim.lr=3e-4" */
    int n_set;
    const char *out;                /* folder of the run; made when it is missing */
    const char *resume;             /* NULL: a new run; "": from the newest sound checkpoint of out; else
                                       from this file */
    const char *init;               /* NULL, or what weights_init takes: safetensors, PyTorch's, a run */
    bool dry_run;                   /* open and build everything, say what it takes, time some steps, stop */
    bool quiet;                     /* nothing but trouble on progress */
    FILE *progress;                 /* NULL: stderr */
    const train_ranks *ranks;       /* that train together, with the same options; NULL: this process alone */

    /* Called before each step, and after each validation; may be NULL. before_step may change the
     * parameters: tests do. */
    void (*before_step)(void *ctx, int64_t step, lt_params *params);
    void (*validated)(void *ctx, const train_validation *v);
    void *ctx;
} train_options;

typedef struct {
    int64_t step;                   /* where the run is */
    int64_t steps_here;             /* taken by this call */
    int64_t skipped;                /* without a finite gradient, in all */
    double loss;                    /* of the last step */
    double best;                    /* the task's first metric at the best checkpoint; infinite without one */
    double img_per_s;
    size_t plan_bytes, bytes;       /* memory of the plans; of all */
    size_t disk_bytes;              /* of the checkpoints that are kept */
    int64_t steps;                  /* of the whole run */
    double eta_seconds;             /* of a dry run: what the steps take that are to come, without their data */
    int signal;                     /* that stopped the run, with LT_ESTOPPED; else 0 */
} train_result;

/**
 * train_run - train, or go on training
 *
 *   out     where it ended; filled on errors as well as far as known; may be NULL
 *
 * Leaves in the run's folder config.json, env.json, README.txt, log.jsonl, metrics.csv and checkpoints/.
 * The weights after step k are a function of configuration and data: of neither threads, ranks, stops nor resumes.
 * SIGINT and SIGTERM save and stop, SIGUSR1 saves and goes on, while this runs.
 *
 * Errors: LT_EINVAL, LT_EFORMAT, LT_EIO for what it was given; LT_ENUMERIC after too many steps in a row
 * without a finite gradient; LT_ENOSPC, LT_ENOMEM; LT_ESTOPPED after a signal.
 */
lt_status train_run(const train_options *o, train_result *out);

#endif
