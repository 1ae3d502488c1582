/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The estimate that sees no picture: each node and vertex where it is on average in training, from the pelvis. The mean
 * of hands from their wrists is the same, less that of the wrists.
 */
#ifndef TASKS_BODY_MEAN_POSE_H
#define TASKS_BODY_MEAN_POSE_H

#include "data/body/set.h"

typedef struct {
    double nodes[BODY_NODES][3], vertices[BODY_VERTICES][3];
} mean_pose;

/* mean_pose_of - of all nodes in the set, and of the vertices of some 200 pictures that are spread over it; in the
 * arena. LT_ENOMEM */
lt_status mean_pose_of(lt_arena *arena, const body_model *m, const body_set *set, mean_pose **out);

#endif
