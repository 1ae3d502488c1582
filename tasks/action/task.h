/* SPDX-License-Identifier: Apache-2.0 */
/* The task of networks that tell what somebody does. */
#ifndef TASKS_ACTION_TASK_H
#define TASKS_ACTION_TASK_H

#include "train/task.h"

extern const task action_task;

#endif
