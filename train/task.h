/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What models are trained for. A task is to the trainer what an op is to a graph: a constant struct of functions. The
 * trainer counts samples, shards, weights and random streams, sums gradients and keeps the run; what a sample is, what
 * is recorded and how good it is, the task knows. So every task has resume, shards and the same bits without code of
 * its own.
 */
#ifndef TRAIN_TASK_H
#define TRAIN_TASK_H

#include "data/loader.h"
#include "estimate/compiled.h"
#include "train/config.h"
#include "train/progress.h"
#include "train/records.h"

/* A run's own, of whatever the task makes it; the struct begins as its task wants. */
typedef struct task_run task_run;

struct task {
    const char *name;                   /* model_class.task of its models */

    /* Group "data" of a config: a struct that begins with train_data_config, and the table of its keys, which begins
     * with or holds TRAIN_DATA_KEYS. */
    size_t data_size;
    const lt_config_key *data_keys;

    const char *const *metrics;         /* keys of the dictionary, NULL-terminated; by the first, checkpoints are best */

    /* Open what the configuration names. Names of files in it are made whole, so that the run's config finds them from
     * any folder. *out is there also after a failure, to be closed, or NULL. */
    lt_status (*open)(lt_arena *arena, train_config *c, task_run **out);
    void (*close)(task_run *r);

    /* Make the model, without values (lt_params_defer); r and set outlive it. */
    lt_status (*build)(task_run *r, const train_config *c, lt_params *set, model *out);

    /* Lines on the data, for whoever watches; facts of them for env.json: "data", "synthetic_data" and the like. */
    void (*describe)(const task_run *r, train_progress *p);
    void (*facts)(const task_run *r, struct cJSON *env);

    /* What is trained on, and what validation looks at (count 0: nothing). r outlives both. */
    loader_source (*samples)(const task_run *r);
    loader_source (*checked)(const task_run *r);
    size_t (*sample_bytes)(const task_run *r);      /* about, of one in a batch */

    /* How the model's graph is recorded and fed with such batches */
    recipe (*recipe)(const task_run *r);
    double (*weight)(const void *batch);            /* of all its samples */
    const char *(*sample_name)(const task_run *r, const void *batch, int i);    /* NULL behind the last one */

    /* After a run on a batch that is validated: a record for each of its samples that counts. *no_losses: some lack what
     * the losses compare with. Then, from all records in the samples' order: a value for each of metrics. */
    lt_status (*score)(task_run *r, const compiled *c, const void *batch, records *out, bool *no_losses);
    void (*measure)(task_run *r, const records *all, double *out);
};

#endif
