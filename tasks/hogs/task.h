/* SPDX-License-Identifier: Apache-2.0 */
/* The task of HOGS: frames of hands with objects in them, and poses to begin from. */
#ifndef TASKS_HOGS_TASK_H
#define TASKS_HOGS_TASK_H

#include "train/task.h"

extern const task hogs_task;

#endif
