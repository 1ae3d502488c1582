/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A re-identification model scored by the trackers that ask it, beside one that does not.
 */
#ifndef TASKS_REID_EVALUATE_H
#define TASKS_REID_EVALUATE_H

#include "tasks/reid/scores.h"
#include "train/task.h"

/* reid_evaluate_run - task.evaluate: rows deepsort, byte and iou; scores.json and table.md, and each tracker's results
 * as MOTChallenge takes them (tracks/deepsort/data/SEQUENCE.txt), in the folder. A limit is one of sequences. */
lt_status reid_evaluate_run(const task_evaluation *e, struct cJSON **scores);

#endif
