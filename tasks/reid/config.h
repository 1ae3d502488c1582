/* SPDX-License-Identifier: Apache-2.0 */
/* Group "data" of a config of the task, and the trackers that it sets. */
#ifndef TASKS_REID_CONFIG_H
#define TASKS_REID_CONFIG_H

#include "train/task.h"
#include "vision/track/tracker.h"

typedef struct {
    train_data_config common;
    int every;                      /* frames from one that is learnt from to the next */
    double visible, noise, flip;

    /* Of the trackers that are scored, in tracker_options' words */
    double min_conf, low_conf, look_conf, max_cosine, max_iou, overlap_cosine, unsure_iou;
    int max_age, n_init, budget;
} reid_data_config;

extern const lt_config_key reid_data_keys[];

static inline const reid_data_config *reid_data_of(const train_config *c)
{
    return (const reid_data_config *)c->data;
}

/* reid_tracker - a tracker's options as the configuration has them */
tracker_options reid_tracker(const train_config *c, track_method method, double fps);

#endif
