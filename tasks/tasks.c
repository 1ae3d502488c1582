/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/tasks.h"

#include "tasks/action/task.h"
#include "tasks/body/task.h"
#include "tasks/detect/task.h"
#include "tasks/hand_object/task.h"
#include "tasks/hogs/task.h"
#include "tasks/point_pairs/task.h"
#include "tasks/reid/task.h"
#include "tasks/splats/task.h"

const task *const tasks[] = {
    &hand_object_task, &hogs_task, &detect_task, &point_pairs_task, &reid_task, &action_task, &body_task,
    &splats_task, NULL,
};
