/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the files of this task share: its configuration, a run, its pictures, and how one gets into a graph.
 */
#ifndef TASKS_SPLATS_RUN_H
#define TASKS_SPLATS_RUN_H

#include "data/transforms/transforms.h"
#include "eval/metrics/lpips_score.h"
#include "models/splats/splats.h"
#include "tasks/splats/density.h"
#include "train/task.h"

/* What a mask's black part is */
typedef enum { SPLATS_IGNORED, SPLATS_BACKGROUND } splats_mask;

typedef struct {
    train_data_config common;
    int holdout, downscale, iterations;
    splats_mask mask;
} splats_data_config;

extern const lt_config_key splats_data_keys[];

static inline const splats_data_config *splats_data_of(const train_config *c)
{
    return (const splats_data_config *)c->data;
}

/* In iterations, which are steps */
typedef struct {
    int64_t iterations;
    int64_t sh_step;                /* the degree of spherical harmonics goes up every so many */
    density_schedule density;
} splats_schedule;

enum { SPLATS_GROUPS = 6 };

/* Views that are learnt from, or that are held out */
typedef struct {
    const task_run *run;
    const int *view;                /* (count) of the set's */
    int64_t count;
} splats_source;

struct task_run {
    lt_arena *arena;
    const train_config *config;
    transforms_set set;
    transforms_picture *picture;    /* (set.n) */
    double extent;
    splats_source train, held_out;
    splats_scene scene;
    const model *m;
    splats_schedule schedule;
    lt_optim_group group[SPLATS_GROUPS];
    density density;
    int degree;                     /* of spherical harmonics, at the step at hand */
    bool shown;                     /* the step at hand shows a view */
    lt_real *seen;                  /* of the step at hand: slopes (N), then radii (N) */
};

/* What a loader makes of views */
typedef struct {
    int count;
    int64_t *view;                  /* (capacity) numbers of the source's; -1: it is not there */
} splats_batch;

/* ---- views.c --------------------------------------------------------------------------------------------- */

/* splats_open_views - cameras and pictures of the configuration's folder. white: what is behind them. Errors: those of
 * transforms_open and transforms_read. */
lt_status splats_open_views(task_run *r, const train_config *c, bool white);

/* splats_bytes - task.bytes: pictures, and Gaussians at their cap */
size_t splats_bytes(const train_config *c, const char **less);

/* splats_find_scene - how large the scene is, where Gaussians begin; sizes into the configuration where it leaves them
 * open. LT_ENOMEM; LT_EINVAL for pictures that are larger than the configuration says. */
lt_status splats_find_scene(task_run *r, train_config *c);

/* splats_views_loader - s outlives the loader's */
loader_source splats_views_loader(const splats_source *s);

/* splats_feed - a view into a graph's inputs; degree of spherical harmonics */
void splats_feed(const task_run *r, const lt_plan *p, const model_record *record, int view, int degree);

/* splats_counts - where a pixel of a view counts */
static inline bool splats_counts(const task_run *r, int view, int64_t pixel)
{
    const uint8_t *mask = r->picture[view].mask;

    return !mask || mask[pixel];
}

/* splats_recipe - draws views of s, or trains on them */
recipe splats_recipe(const splats_source *s, bool training);

/* ---- results.c, show.c ------------------------------------------------------------------------------------------- */

enum { SPLATS_PSNR, SPLATS_SSIM, SPLATS_LPIPS_RAW01, SPLATS_LPIPS_SYM, SPLATS_SCORES };

/* splats_score_view - of what a graph has drawn of a view, where its pixels count; LPIPS NaN without a judge.
 * LT_ENOMEM */
lt_status splats_score_view(const task_run *r, const compiled *c, int view, const eval_lpips *judge,
                            double out[SPLATS_SCORES]);

/* task.evaluate: in the folder scores.json, table.md, per-sample.csv, and pictures.png with the worst views.
 * task.predict: the held-out views of each folder, or all where none is, as NAME.png. task.export: the Gaussians in the
 * world. */
lt_status splats_evaluate(const task_evaluation *e, struct cJSON **scores);
lt_status splats_predict(const task_prediction *p, int64_t *written);
lt_status splats_export(const task_export *e);

/* splats_show - task.pose: held-out views, or all where none is, as their cameras see the scene, a part of its own */
lt_status splats_show(const task_posing *p);

extern const char *const splats_score_keys[];

#endif
