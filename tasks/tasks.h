/* SPDX-License-Identifier: Apache-2.0 */
/* All tasks there are. */
#ifndef TASKS_TASKS_H
#define TASKS_TASKS_H

#include "train/task.h"

extern const task *const tasks[];       /* NULL-terminated */

#endif
