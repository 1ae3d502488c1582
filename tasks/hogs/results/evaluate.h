/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Scoring a trained HOGS model on frames that it has not seen: renderings and poses, beside the initial poses, the mean
 * offset of the training frames, and renderings that see another frame's image.
 */
#ifndef TASKS_HOGS_RESULTS_EVALUATE_H
#define TASKS_HOGS_RESULTS_EVALUATE_H

#include "eval/metrics/lpips_score.h"
#include "eval/tables/tables.h"
#include "tasks/hogs/run.h"

/* hogs_evaluate - task.evaluate. In the folder: scores.json, table.md, per-sample.csv, pictures.png */
lt_status hogs_evaluate(const task_evaluation *e, struct cJSON **scores);

/* ---- between evaluate.c and report.c --------------------------------------------------------------------- */

typedef enum { HOGS_ROW_MODEL, HOGS_ROW_INITIAL, HOGS_ROW_MEAN, HOGS_ROW_SWAP, HOGS_ROW_NO_ROTATION, HOGS_ROW_MINIMUM,
    HOGS_ROWS } hogs_row;

typedef struct {
    const task_evaluation *o;
    task_run run;                   /* the model, its data, what feeds it */
    hogs_means means[HOGS_ROWS];
    bool has[HOGS_ROWS];
    int64_t samples;
    const char **name;              /* (samples) */
    double (*per_sample)[HOGS_SCORES];      /* the model's */
    hogs_touch touch;
    eval_lpips *judge;
    bool *meshed;                   /* (source's frames) whose surfaces are scored */
    int meshes, no_surface;         /* how many were; surfaces that there were none of */
    bool *held;                     /* (source's frames) whose object is scored as HOLD does; NULL: not in such data */
    int *sequence;                  /* (source's frames) of each; sequences: how many there are */
    bool *begun;                    /* (sequences) whose first frame was scored */
    int sequences, held_frames;
    hogs_means *by_sequence;        /* (sequences) of the model, of frames that are held */
    float mean_R[9], mean_t[3];     /* the training frames' mean offset */
    lt_arena *arena;
    uint8_t *picture;               /* (pictures, H, 4 W, 3): image, its parts, drawn, the object drawn */
    int pictures;
} hogs_evaluation;

enum { HOGS_PICTURES = 8, HOGS_PANELS = 4 };

/* hogs_row_name - "model"; hogs_row_label - of tables and claims */
const char *hogs_row_name(hogs_row row);
const char *hogs_row_label(hogs_row row);

struct cJSON *hogs_evaluation_json(const hogs_evaluation *e);
lt_status hogs_evaluation_print(const hogs_evaluation *e, FILE *f, eval_format format);
lt_status hogs_evaluation_write(const hogs_evaluation *e, const struct cJSON *scores);

#endif
