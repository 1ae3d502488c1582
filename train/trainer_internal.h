/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the trainer's files share: setup.c makes it, step.c moves it by its shards (shards.c), save.c keeps it,
 * trainer.c is the loop.
 */
#ifndef TRAIN_TRAINER_INTERNAL_H
#define TRAIN_TRAINER_INTERNAL_H

#include "estimate/checkpoint/checkpoint.h"
#include "estimate/compiled.h"
#include "estimate/weights/weights.h"
#include "train/progress.h"
#include "train/task.h"
#include "train/trainer.h"
#include "train/tree_sum.h"

/* Of a part of a shard: its share of the batch's weight (0: no sample counts), and its losses */
typedef struct {
    double share, loss, part[MODEL_PORTS];
} shard_loss;

typedef struct {
    const train_options *opt;
    lt_arena *arena;
    train_config config;
    const char *config_text;        /* resolved, one line of JSON */
    task_run *run;                  /* what the task opened */
    loader_source samples, checked;
    lt_params *params;
    model model;
    task_phase phase;               /* that train is compiled for */
    compiled train;
    compiled check;                 /* to validate; empty without */
    lt_optim *optim;
    tree_sum *sum;
    shard_loss *shard_loss;         /* of the last step: a row of the plan's parts for each shard */
    lt_real *message;               /* room for what ranks send each other of gradients; NULL where there is one */
    loader *loader;
    train_log log;
    train_progress progress;
    const char *checkpoints;        /* the folder */
    int locked;                     /* a descriptor of opt->out while it is ours, else -1 */

    checkpoint_state state;
    int64_t steps_of_epoch, total_steps, first_step;
    int64_t saved_step;             /* of the last checkpoint, -1 before */
    size_t resident;                /* of the process, before the model was made */
    double saved_at, began_at, step_seconds;
    int bad_in_a_row, samples_warned, checks_warned;
    bool torn;                      /* a step failed while it changed parameters: they are not to be kept */
    int signal;                     /* that stopped the run, or 0 */
    train_step_record record;       /* of the last step */
    bool improved;                  /* the last validation was the best, and is not saved yet */
} trainer;

/* setup.c: everything up to the first batch; trainer_fini takes it apart, at whatever point it stopped */
lt_status trainer_init(trainer *t, const train_options *o);
lt_status trainer_enter(trainer *t);            /* the phase of the next step: another batch, another graph */
void trainer_fini(trainer *t);

/* forecast.c: forecast_task refuses, before the task is opened, what takes more memory than there is.
 * trainer_bytes - program, data's list, plans, batches, parameters, optimiser, and what the task says of itself.
 * forecast_seconds - that the steps to come take, their data and validations not counted: the plans of all phases are
 * run, so the run cannot go on. */
lt_status forecast_task(const trainer *t);
size_t trainer_plan_bytes(const trainer *t);
size_t trainer_bytes(const trainer *t);
lt_status forecast_seconds(trainer *t, double *out);
void trainer_describe(trainer *t);

/* run_folder.c: run_folder_lock, before anybody looks into it, refuses a folder where another process trains;
 * run_folder_check refuses an --out that holds a run already; run_folder_make makes the folder, sweeps what a killed
 * run left half written, and writes config.json, env.json and README.txt. run_folder_agree refuses ranks that do not
 * all train the same, before any of them makes something. */
lt_status run_folder_lock(trainer *t);
lt_status run_folder_check(const trainer *t);
lt_status run_folder_agree(const trainer *t);
lt_status run_folder_make(trainer *t);

/* step.c: one step on a batch, recorded in t->record. LT_ENUMERIC after too many bad ones. */
lt_status trainer_step(trainer *t, const void *batch);

/* shards.c: shards_new - room for the sums of the phase's shards; shards_free. shards_slots - the slots of a batch that
 * this rank reads. shards_run - gradients of a batch of weight total into the parameters, losses into the record; *ran:
 * shards with samples. shards_find_culprit - the first tensor in such a run that is not finite. */
enum { SHARDS_WHERE = 256 };
lt_status shards_new(trainer *t);
void shards_free(trainer *t);
void shards_slots(const trainer *t, int *first, int *n);
lt_status shards_run(trainer *t, const void *batch, double total, int *ran);
lt_status shards_find_culprit(trainer *t, const void *batch, double total, char where[SHARDS_WHERE]);

/* validate.c: score the model as it is; step and epoch are the caller's. LT_ESTOPPED after a signal. */
lt_status trainer_validate(trainer *t, train_validation *out);

/* save.c */
lt_status trainer_save(trainer *t);             /* step file, last, best; does nothing when just done */
lt_status trainer_resume(trainer *t);           /* load what the options ask for */
size_t trainer_disk_bytes(const trainer *t);
lt_status trainer_check_disk(trainer *t);       /* room for two checkpoints, at least */

#endif
