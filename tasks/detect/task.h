/* SPDX-License-Identifier: Apache-2.0 */
/* Detectors: what the trainer asks of them. */
#ifndef TASKS_DETECT_TASK_H
#define TASKS_DETECT_TASK_H

#include "train/task.h"

extern const task detect_task;

#endif
