/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/tasks.h"

#include "tasks/detect/task.h"
#include "tasks/hand_object/task.h"

const task *const tasks[] = { &hand_object_task, &detect_task, NULL };
