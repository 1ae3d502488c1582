/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The task of a point backbone: which two of many partial views are of the same shape.
 */
#ifndef TASKS_POINT_PAIRS_TASK_H
#define TASKS_POINT_PAIRS_TASK_H

#include "train/task.h"

extern const task point_pairs_task;

#endif
