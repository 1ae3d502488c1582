/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A body model scored, beside the mean pose of what it was trained on.
 */
#ifndef TASKS_BODY_EVALUATE_H
#define TASKS_BODY_EVALUATE_H

#include "tasks/body/scores.h"
#include "train/task.h"

/* body_evaluate_run - task.evaluate: scores.json and pictures.png in the folder */
lt_status body_evaluate_run(const task_evaluation *e, struct cJSON **scores);

#endif
