/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How far an estimated body is from the true one.
 */
#ifndef TASKS_BODY_SCORES_H
#define TASKS_BODY_SCORES_H

#include "assets/body/body.h"

#include <stdio.h>

struct cJSON;

enum { BODY_MPJPE, BODY_HAND_MPJPE, BODY_PA_MPJPE, BODY_PVE, BODY_METRICS };

/* body_score_keys - in this order, "mpjpe_mm" first; ends with NULL */
extern const char *const body_score_keys[];

typedef struct { double mm[BODY_METRICS]; } body_errors;

/**
 * body_errors_of - of one sample, in millimetres
 *
 *   nodes         (BODY_NODES, 3) metres, wherever the pelvis is
 *   vertices      (BODY_VERTICES, 3) in the same place; both NULL: not measured, NaN
 *
 * MPJPE: the 25 nodes of the body, pelvis on pelvis; of a hand its 20, wrist on wrist; PA: the 25 after the best
 * similarity without reflections; PVE: all vertices, pelvis on pelvis.
 */
void body_errors_of(const double (*nodes)[3], const double (*true_nodes)[3], const double (*vertices)[3],
                    const double (*true_vertices)[3], body_errors *out);

/* What an evaluation found: sums, until body_scores_mean */
typedef struct {
    body_errors model, mean_pose;   /* mean_pose: each node and vertex where it is on average in training */
    int64_t images;
    int subjects;
    bool synthetic;
} body_scores;

/* body_scores_json - for cJSON_Delete, NULL without memory. body_scores_print - as text. */
struct cJSON *body_scores_json(const body_scores *s);
void body_scores_print(const body_scores *s, FILE *f);

#endif
