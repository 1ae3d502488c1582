/* SPDX-License-Identifier: Apache-2.0 */
/* The task of models that look at a crop with one hand and one object. */
#ifndef TASKS_HAND_OBJECT_TASK_H
#define TASKS_HAND_OBJECT_TASK_H

#include "train/task.h"

extern const task hand_object_task;

#endif
