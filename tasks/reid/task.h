/* SPDX-License-Identifier: Apache-2.0 */
/* The task of networks that tell who is who, and of the trackers that ask them. */
#ifndef TASKS_REID_TASK_H
#define TASKS_REID_TASK_H

#include "train/task.h"

extern const task reid_task;

#endif
