/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Group "data" of HOGS's configuration: frames, the poses they begin with, and how long each stage is.
 */
#ifndef TASKS_HOGS_CONFIG_H
#define TASKS_HOGS_CONFIG_H

#include "train/config.h"

typedef struct {
    train_data_config common;
    const char *objects, *hand, *poses;
    int setup, filter, masks;
    bool jitter;
    int iterations, pose_epochs, cache_mb;
} hogs_data_config;

typedef enum { HOGS_MASKS_DATA, HOGS_MASKS_INITIAL } hogs_masks;

extern const lt_config_key hogs_data_keys[];

/* hogs_data_of - of a configuration of this task */
const hogs_data_config *hogs_data_of(const train_config *c);

#endif
