/* SPDX-License-Identifier: Apache-2.0 */
#ifndef TASKS_ACTION_CLIPS_H
#define TASKS_ACTION_CLIPS_H

#include "tasks/action/config.h"

/* action_clips_open - the clips in c's data.dir: a folder of them, or DexYCB, whose takes are cut. Errors: those of
 * either; LT_EUSAGE: skeletons are asked for, and DexYCB has none */
lt_status action_clips_open(lt_arena *arena, const train_config *c, action_set *out);

#endif
