/* SPDX-License-Identifier: Apache-2.0 */
/* Group "data" of a config of the task, and the optimiser that the rule makes of group "optim". */
#ifndef TASKS_DETECT_CONFIG_H
#define TASKS_DETECT_CONFIG_H

#include "libtensor/optim/optim.h"
#include "train/task.h"

typedef struct {
    train_data_config common;
    const char *names;              /* of the classes, with commas between */
    int optimizer;                  /* detect_optimizer */
    bool augment;
    double mosaic;
    int close_mosaic;
    double scale, translate, flip, hue, saturation, value;
} detect_config;

typedef enum { DETECT_OPTIM_AUTO, DETECT_OPTIM_GIVEN } detect_optimizer;

extern const lt_config_key detect_keys[];

static inline const detect_config *detect_config_of(const train_config *c)
{
    return (const detect_config *)c->data;
}

enum { DETECT_GROUPS = 2 };

/**
 * detect_groups - weights, which are decayed, and biases and norms, which are not
 *
 * With data.optimizer auto: SGD (0.01, momentum 0.9) where the run has more than 10,000 steps of 64 images, else AdamW
 * (0.002 * 5 / (4 + classes)); decay is optim.weight_decay * batch / 64, and biases warm up from 0. Given: kind, rate
 * and momentum of group "optim"; with SGD biases warm up from 0.1.
 */
void detect_groups(const train_config *c, int64_t images, int classes, lt_optim_group out[DETECT_GROUPS]);

#endif
