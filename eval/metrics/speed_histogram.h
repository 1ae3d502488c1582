/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The baseline for actions: how fast a few joints move, and the class whose mean is nearest. It learns nothing else, so
 * that a set's difficulty can be fixed by it before any network is trained.
 */
#ifndef EVAL_METRICS_SPEED_HISTOGRAM_H
#define EVAL_METRICS_SPEED_HISTOGRAM_H

#include "data/action/action.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SPEED_JOINTS = 6, SPEED_BINS = 16, SPEED_FEATURES = SPEED_JOINTS * SPEED_BINS };

/* speed_histogram - of wrists, elbows, nose and pelvis the shares of a window's steps with such a speed
 *
 *   body     (3, T, 65) metres, at 30 frames a second
 *
 * Bins are spread evenly over the logarithm from 0.02 to 4 m/s; what is slower or faster counts in the outer ones. */
void speed_histogram(const float *body, int T, double out[SPEED_FEATURES]);

/* Means of classes, as sums; begins as zeros. */
typedef struct {
    double sum[ACTION_CLASSES][SPEED_FEATURES];
    int64_t n[ACTION_CLASSES];
} speed_means;

void speed_means_add(speed_means *m, int cls, const double histogram[SPEED_FEATURES]);

/* speed_means_nearest - the class with the nearest mean (L2) of those that have one; -1: none has */
int speed_means_nearest(const speed_means *m, const double histogram[SPEED_FEATURES]);

#ifdef __cplusplus
}
#endif
#endif
