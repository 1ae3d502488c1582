/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Batches of windows, and how they come into the model's graph.
 */
#ifndef TASKS_ACTION_BATCH_H
#define TASKS_ACTION_BATCH_H

#include "tasks/action/config.h"

/* A source of windows. */
typedef struct {
    const action_set *set;
    const action_window *window;
    int64_t count;                  /* the first so many are looked at */
    int T, min_valid;
    action_streams streams;
    double hide;                    /* of training; 0 elsewhere */
    uint64_t seed;
} action_feed;

typedef struct {
    int count, T;
    int64_t *index;
    int *cls;
    float *body, *hand_object, *valid, *on;     /* (capacity, ...) as the model's inputs are */
} action_batch;

/* action_source - feed outlives it; window i of an epoch is a function of both and of the seed */
loader_source action_source(const action_feed *feed);

/* action_batch_feed - as recipe.feed: a place without a window has the first one, and counts for nothing */
double action_batch_feed(const lt_plan *p, const model_record *r, const action_batch *b, int first);

#endif
