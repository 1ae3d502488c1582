/* SPDX-License-Identifier: Apache-2.0 */
/* Group "data" of a config of the task. */
#ifndef TASKS_REID_CONFIG_H
#define TASKS_REID_CONFIG_H

#include "train/task.h"

typedef struct {
    train_data_config common;
    int every;                      /* frames from one that is learnt from to the next */
    double visible, noise, flip;
} reid_data_config;

extern const lt_config_key reid_data_keys[];

static inline const reid_data_config *reid_data_of(const train_config *c)
{
    return (const reid_data_config *)c->data;
}

#endif
