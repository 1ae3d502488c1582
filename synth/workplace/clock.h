/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Clocks of cameras: each stamps its own time, 5 ms off at most, and loses one to two frames in a hundred; of several
 * one lags by a constant. A stamp is a function of seed, camera and frame.
 */
#ifndef SYNTH_WORKPLACE_CLOCK_H
#define SYNTH_WORKPLACE_CLOCK_H

#include "data/recording/recording.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    uint64_t seed;
    int n;
    double lag[RECORDING_CAMERAS], loss[RECORDING_CAMERAS];     /* seconds; share of frames */
} workplace_clock;

/* workplace_clock_draw - of n cameras; the first one never lags */
void workplace_clock_draw(uint64_t seed, int n, workplace_clock *out);

/* workplace_time - the true time of frame k, seconds */
double workplace_time(int k);

/* workplace_stamp - what camera c stamps on frame k: false where it loses it */
bool workplace_stamp(const workplace_clock *clock, int c, int k, double *out);

#ifdef __cplusplus
}
#endif
#endif
