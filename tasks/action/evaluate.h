/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An action model scored: with both streams, with the body alone, with stream 2 alone, beside the baseline.
 */
#ifndef TASKS_ACTION_EVALUATE_H
#define TASKS_ACTION_EVALUATE_H

#include "tasks/action/scores.h"
#include "train/task.h"

/* action_evaluate_run - task.evaluate: scores.json and table.md in the folder. The split "train" is the side that was
 * trained on. A limit is one of windows, spread over them. */
lt_status action_evaluate_run(const task_evaluation *e, struct cJSON **scores);

/* action_find - the class of the largest of ten logits, the first of equals */
int action_find(const lt_real *logits);

#endif
