/* SPDX-License-Identifier: Apache-2.0 */
/* The task of networks that see a whole body in the picture of a person. */
#ifndef TASKS_BODY_TASK_H
#define TASKS_BODY_TASK_H

#include "train/task.h"

extern const task body_task;

#endif
