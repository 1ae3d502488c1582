/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What makes films hard for trackers, counted: who passes before whom, who is hidden for how long, who leaves and comes
 * back.
 */
#ifndef SYNTH_TRACK_EVENTS_H
#define SYNTH_TRACK_EVENTS_H

#include "synth/write/mot.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct { int64_t crossings, occlusions, returns; } track_events;

/* One thing of a film, so far. */
typedef struct {
    int id;
    bool here, hidden;
    double since;                   /* seconds: when it was hidden, or left */
    synth_pixels box;
} track_state;

typedef struct {
    track_state state[SYNTH_THINGS];
    int n;
    bool met[SYNTH_THINGS][SYNTH_THINGS];       /* whether two boxes overlap */
} track_watch;

/* track_events_add - the n things of a frame at this time; begin each film with an empty watch. A crossing is two boxes
 * that come to an IoU of 0.3, an occlusion 1 to 4 seconds at less than a fifth visible, a return coming back after half
 * a second or more outside the picture. */
void track_events_add(track_events *e, track_watch *w, const synth_mot_truth *truth, int n, double time);

#ifdef __cplusplus
}
#endif
#endif
