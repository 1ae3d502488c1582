/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shards of a step side by side, one a thread. A small network's layers are too short for several threads, and its
 * maps wander between their caches; with a shard each they share nothing but the weights.
 */
#ifndef TRAIN_LANES_H
#define TRAIN_LANES_H

#include "train/compiled.h"
#include "train/config.h"

/* What runs a shard. All lanes have the weights of the first; each has gradients of its own. */
typedef struct {
    lt_params *params;
    model model;
    compiled train;
    double share;                   /* of the shard that it ran last, among the weights of its batch */
} train_lane;

typedef struct {
    int n;
    train_lane *lane;               /* lane[0]: with the parameters and the model that it was made for */
} train_lanes;

/**
 * lanes_new - as many lanes as help, one at least
 *
 *   first    lane[0]'s parameters and model; they stay the caller's
 *   hand     as train_config_model takes it
 *
 * The number follows from shards, threads and the plan's size, and changes no result. Errors: those of compiled_new;
 * LT_ENOMEM. *out can be freed also after an error.
 */
lt_status lanes_new(lt_arena *arena, const train_config *c, const lt_hand_layer *hand, const train_lane *first,
                    train_lanes *out);
void lanes_free(train_lanes *l);

/* lanes_plan_bytes - of all plans; lanes_param_bytes - of the parameters that the lanes behind the first have */
size_t lanes_plan_bytes(const train_lanes *l);
size_t lanes_param_bytes(const train_lanes *l);

#endif
