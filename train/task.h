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
#include "estimate/metric.h"
#include "estimate/posed/posed.h"
#include "libtensor/geometry/opacity/opacity.h"
#include "libtensor/io/array/array.h"
#include "libtensor/optim/optim.h"
#include "train/config.h"
#include "train/log.h"
#include "train/progress.h"
#include "train/records.h"

/* A run's own, of whatever the task makes it; the struct begins as its task wants. */
typedef struct task_run task_run;

/* What the trainer does from a step on. */
typedef struct {
    const char *name;                   /* "skin": for whoever watches; NULL where there is one phase */
    int batch, shards;                  /* samples in a step; parts of them with statistics of their own */
    int64_t until;                      /* the first step of the next phase, or where the run ends */
    uint64_t groups;                    /* bit k: optimiser group k steps */
    uint64_t shape;                     /* as soon as it is another number, the graph is recorded again */
} task_phase;

/* What `palmar eval` asks for. Everything is borrowed. */
typedef struct {
    lt_arena *arena;
    train_config *config;               /* the run's, its data those that are to be scored */
    const char *checkpoint;             /* the file */
    int64_t step;                       /* that it is of */
    const char *hand;                   /* in place of the run's hand model; or NULL */
    const char *split, *folder;
    int64_t limit;                      /* samples, spread over the split; 0: all */
    int meshes;                         /* of each object: frames whose surfaces are scored, of tasks that have any */
    const char *const *lpips;           /* (n_lpips) files of LPIPS's weights, of tasks that score pictures */
    int n_lpips;
    FILE *tables;                       /* NULL: none are printed */
    bool (*progress)(void *ctx, int64_t done, int64_t total);   /* false: stop, with LT_ESTOPPED */
    void *ctx;
} task_evaluation;

/* What `palmar predict` asks for. Everything is borrowed. */
typedef struct {
    lt_arena *arena;
    train_config *config;               /* the run's */
    const char *checkpoint;
    const char *hand;                   /* in place of the run's hand model; or NULL */
    const char *const *inputs;
    int n_inputs;
    const char *out;                    /* folder, which is made */
    FILE *messages;                     /* NULL: quiet */
    bool (*stop)(void);
} task_prediction;

/* What asks a trained model for frames as it draws them (estimate/posed/posed.h). Borrowed. */
typedef struct {
    lt_arena *arena;
    train_config *config;               /* the run's */
    const char *checkpoint, *hand;      /* hand: in place of the run's hand model; or NULL */
    const char *data;                   /* in place of the run's; or NULL */
    const int64_t *frame;               /* (n_frames) numbers from 0 among those that training validates on; NULL: at
                                         * most n_frames of them, spread over all */
    int64_t n_frames;
    lt_status (*visit)(void *ctx, const posed_frame *f);
    void *ctx;
    bool (*stop)(void);                 /* may be NULL */
} task_posing;

/* A surface that was written */
typedef struct {
    const char *file, *part;            /* part: "hand", "object" */
    int64_t frame;
    int vertices, faces, components;
    bool watertight;
    double seconds;                     /* to make it, not to write it */
} task_exported;

/* What `palmar export` asks for that is no network: surfaces into a folder, or Gaussians into a file. Borrowed. */
typedef struct {
    lt_arena *arena;
    train_config *config;               /* the run's */
    const char *checkpoint, *hand;      /* hand: in place of the run's hand model; or NULL */
    const int64_t *frame;               /* (n_frames) numbers from 0 among those that training validates on */
    int n_frames;
    const char *folder, *file;          /* one of them */
    const char *format;                 /* "ply", "obj", "glb"; of Gaussians "ply", "glb", "splat" */
    lt_opacity_rule rule;               /* of surfaces, as lt_opacity_mesh has them */
    double iso;
    const char *set;                    /* Gaussians of that one in its canonical place; NULL: of a frame, posed */
    bool animated;                      /* the file has the surfaces of all frames, one after the other */
    void (*made)(void *ctx, const task_exported *one);
    void *ctx;
} task_export;

struct task {
    const char *name;                   /* model_class.task of its models */

    /* Group "data" of a config: a struct that begins with train_data_config, and the table of its keys, which begins
     * with TRAIN_DIR_KEY and holds TRAIN_LOADER_KEYS. */
    size_t data_size;
    const lt_config_key *data_keys;

    const model_class *const *models;   /* of its own, beside the zoo's; NULL-terminated, or NULL */
    const char *const *metrics;         /* keys, NULL-terminated; by the first one, checkpoints are best */
    const metric *own_metrics;          /* that the dictionary lacks, until one without a key; or NULL */

    /* About what the task will hold itself, once parameters have grown and caches are full, before it is opened; *less:
     * the key whose smaller value takes less. NULL: nothing to speak of. */
    size_t (*bytes)(const train_config *c, const char **less);

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

    /* How the model's graph is recorded and fed with such batches: a phase's, or where phase is NULL the one that is
     * validated */
    recipe (*recipe)(const task_run *r, const task_phase *phase);
    double (*weight)(const void *batch);            /* of all its samples */
    const char *(*sample_name)(const task_run *r, const void *batch, int i);    /* NULL behind the last one */

    /* After a run on a batch that is validated: a record for each of its samples that counts. *no_losses: some lack
     * what the losses compare with. Then, from all records in the samples' order: a value for each of metrics. */
    lt_status (*score)(task_run *r, const compiled *c, const void *batch, records *out, bool *no_losses);
    void (*measure)(task_run *r, const records *all, double *out);

    /* What to say, beyond the metrics, of a model whose last step is done; called once. NULL: nothing. */
    void (*conclude)(task_run *r, train_progress *p);

    /* ---- for what moves in phases, or grows; a task may have none of these, but phase and groups go together ---- */

    /* The phase of a step, counted from 0. Without: optim.batch samples in optim.shards shards as long as the run
     * is. */
    task_phase (*phase)(const task_run *r, int64_t step);

    /* Optimiser groups, *n of them, as long as r; average: or NULL. Without: one recipe for all, by the keys of
     * optim. */
    const lt_optim_group *(*groups)(const task_run *r, int *n, lt_optim_average *average);

    /* Before a step, counted from 0, on a batch: touch the rows that it reads and moves (libtensor/graph/rows.h). */
    lt_status (*rows)(task_run *r, const void *batch, int64_t step);

    /* An array that observe fills for each shard after its run, and that then holds the sum over the shards' tree. */
    lt_real *(*observed)(const task_run *r, int64_t *n);
    void (*observe)(task_run *r, const compiled *c, const void *batch, int first);

    /* After the sum of a step's shards, before the optimiser moves: grow, prune, reset. step counts from 1. */
    lt_status (*adapt)(task_run *r, int64_t step, lt_optim *o);

    /* After a step: how many of whatever is counted there are, for log.jsonl; how many, at most TRAIN_COUNTS. */
    int (*counts)(const task_run *r, train_count out[TRAIN_COUNTS]);

    /* Its own state in a checkpoint, both or none: as checkpoint_own has them. */
    int (*save)(const task_run *r, lt_named_array *out, int room);
    lt_status (*load)(task_run *r, const char *path, const lt_named_array *entry, size_t n);

    /* ---- with the trained model ---- */

    /* `palmar eval`: score it, leave files in the folder, print tables. *scores: what scores.json holds, the caller's,
     * whose first row is the model's. NULL: eval knows the task by itself. */
    lt_status (*evaluate)(const task_evaluation *e, struct cJSON **scores);
    const char *const *scores;          /* keys of its rows, NULL-terminated */

    /* `palmar predict`: write what it makes of the inputs; *written: of how many frames. NULL: predict knows the task
     * by itself. */
    lt_status (*predict)(const task_prediction *p, int64_t *written);

    /* `palmar export --mesh`, or -o of a format of Gaussians. NULL: the task has no surfaces. */
    lt_status (*export)(const task_export *e);

    /* Show frames as the model draws them, in the order asked for. Errors: a number beyond the last frame, a frame that
     * is asked for and shows nothing; those of visit. NULL: the task draws none. */
    lt_status (*pose)(const task_posing *p);
};

#endif
