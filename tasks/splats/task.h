/* SPDX-License-Identifier: Apache-2.0 */
/* The task of still scenes: photos with known cameras in, Gaussians out. */
#ifndef TASKS_SPLATS_TASK_H
#define TASKS_SPLATS_TASK_H

#include "train/task.h"

extern const task splats_task;

#endif
