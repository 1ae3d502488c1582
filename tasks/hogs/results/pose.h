/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens a trained model with its data, and shows frames as it draws them.
 */
#ifndef TASKS_HOGS_RESULTS_POSE_H
#define TASKS_HOGS_RESULTS_POSE_H

#include "tasks/hogs/run.h"

typedef struct {
    task_run run;                   /* run.train: the split that training validates on, or the training split where that
                                     * is all */
    model m;
    lt_params *params;
} hogs_opened;

/* hogs_open_trained - a checkpoint and the data of its run, or those in the folder `data`; hand and data may be NULL.
 * hogs_close_trained follows in any case. */
lt_status hogs_open_trained(lt_arena *arena, train_config *config, const char *checkpoint, const char *hand,
                            const char *data, hogs_opened *out);
void hogs_close_trained(hogs_opened *o);

/* hogs_show - task.pose. Frames are those with initial poses. */
lt_status hogs_show(const task_posing *p);

#endif
