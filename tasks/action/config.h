/* SPDX-License-Identifier: Apache-2.0 */
/* Group "data" of a config of the task. */
#ifndef TASKS_ACTION_CONFIG_H
#define TASKS_ACTION_CONFIG_H

#include "data/action/windows.h"
#include "train/task.h"

typedef enum { STREAMS_BOTH, STREAMS_BODY, STREAMS_HAND_OBJECT } action_streams;

typedef struct {
    train_data_config common;
    int windows, split, held_out;   /* action_window_options' */
    int streams;                    /* action_streams */
    int min_valid;
    double hide;
    const char *seen;               /* lines of palmar watch; "": none */
} action_data_config;

extern const lt_config_key action_data_keys[];

static inline const action_data_config *action_data_of(const train_config *c)
{
    return (const action_data_config *)c->data;
}

/* action_windows_of - windows of T frames as the configuration has them, of the scored side or the other */
action_window_options action_windows_of(const train_config *c, int T, bool evaluation);

#endif
