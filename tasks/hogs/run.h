/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the files of this task share: a run, its stages, what a batch becomes in a graph, and how sets grow.
 */
#ifndef TASKS_HOGS_RUN_H
#define TASKS_HOGS_RUN_H

#include "assets/hands.h"
#include "tasks/hogs/frames.h"
#include "tasks/hogs/lists.h"
#include "tasks/hogs/score.h"
#include "tasks/hogs/vit_cache.h"
#include "tasks/splats/density.h"
#include "train/task.h"

/* Steps from 0 on: skin, then stage 1's iterations, then poses. Intervals are in iterations of stage 1. */
typedef struct {
    int64_t skin, iterations, poses;        /* steps of stages 0, 1 and 2 */
    int64_t warm;                   /* iterations in which the skinning field's loss counts much */
    int64_t gpm_start;              /* the iteration that G-PM begins at; iterations: never */
    int64_t bend_start;             /* the avatar keeps its shape before */
    int64_t sh_step;                /* the degree of spherical harmonics goes up every so many */
    int64_t place_steps;            /* in which the learning rate of places falls */
    int64_t lists;                  /* neighbours and insides are made anew every so many */
    int lpips_every;
    density_schedule density;
} hogs_schedule;

hogs_schedule hogs_schedule_of(const hogs *m, int64_t iterations, int64_t pose_epochs, int64_t frames);
hogs_stage hogs_stage_of(const hogs_schedule *s, int64_t step);

#define HOGS_EXTENT 1.0395          /* metres: the scene's */
enum { HOGS_GROUPS = 16, HOGS_POSE_BATCH = 8 };     /* frames in a step of stage 2 */

/* hogs_optim_groups - how each part learns: *n of them; hogs_stage_groups - which of them do so in a stage.
 * hogs_pose_group - G-PM's, in stage 2 */
const lt_optim_group *hogs_optim_groups(const hogs *m, const hogs_schedule *s, lt_optim_group out[HOGS_GROUPS], int *n);
uint64_t hogs_stage_groups(hogs_stage stage);
int hogs_pose_group(const hogs *m, lt_optim_group *out);

/* What a graph's feeding needs to know */
typedef struct {
    const struct task_run *run;
    hogs_stage stage;
} hogs_feeder;

struct task_run {
    lt_arena *arena;
    const train_config *config;
    hands hands;
    int tips[5];
    dataset *train, *evaluation;
    initial_poses *train_poses, *check_poses;
    hogs_source train_source, check_source;
    hogs_sets sets;
    hogs_rig *rig;                  /* (hands) of the subjects */
    model *m;
    hogs_schedule schedule;
    lt_optim_group group[HOGS_GROUPS];
    hogs_feeder feeder[HOGS_STAGES];
    hogs_lists lists;
    vit_cache *vit_cache;           /* NULL: the ViT learns, or there is none */
    density density;
    int64_t iteration;              /* of stage 1, that the step at hand is; -1 before */
    int degree;                     /* of spherical harmonics */
    const hogs_frame *frame;        /* of the step at hand in stage 1 */
    lt_real *seen;                  /* what observe measured: slope and radius of the frame's two sets */
};

/* hogs_feed - recipe.feed, ctx a hogs_feeder */
double hogs_feed(const void *ctx, const lt_plan *p, const model_record *r, const void *batch, int first, int part,
                 int n);

/* hogs_recipe - of a stage: its graph, of one frame where it is to evaluate, and its feeding */
recipe hogs_recipe(const struct task_run *r, hogs_stage stage);

/* hogs_posed_at - where the initial pose puts a set's Gaussian row; hand: by the nearest vertex's weights */
typedef struct {
    const hogs *m;
    const hogs_lists *lists;
    const hogs_rig *rig;
    const hogs_frame *frame;
    hogs_bone bone[LT_HAND_JOINTS];
} hogs_placer;

hogs_placer hogs_placer_of(const hogs *m, const hogs_lists *lists, const hogs_rig *rigs, const hogs_frame *f);
void hogs_posed_at(const hogs_placer *p, bool object, int64_t row, double out[3]);

#endif
