/* SPDX-License-Identifier: Apache-2.0 */
/* Group "data" of a config of the task. */
#ifndef TASKS_BODY_CONFIG_H
#define TASKS_BODY_CONFIG_H

#include "train/task.h"

typedef struct {
    train_data_config common;
    const char *body;               /* as run_body_open takes it */
    double scale, shift, rotation_deg, flip, colour, heads_rate, matrices_rate;
} body_data_config;

extern const lt_config_key body_data_keys[];

enum { BODY_GROUPS = 3 };

/* body_groups - how weights learn: the layers that turn all joints of body or hands at once, the transformer's matrices,
 * and all others */
void body_groups(const train_config *c, lt_optim_group out[BODY_GROUPS]);

static inline const body_data_config *body_data_of(const train_config *c)
{
    return (const body_data_config *)c->data;
}

#endif
