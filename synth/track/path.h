/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How things of a film for trackers come and go. Each has a lane of its own, at its own distance from the camera, so
 * none meets another; along it, it crosses the picture, waits behind a screen, leaves and comes back, or stands still.
 */
#ifndef SYNTH_TRACK_PATH_H
#define SYNTH_TRACK_PATH_H

#include "libtensor/base/rng.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { TRACK_LANES = 5, TRACK_SCREENS = 2 };

/* Where a screen hides what is behind it. Across the picture, -1 is its left border and 1 its right one. */
typedef struct { double middle; int lane; } track_screen;       /* hides the lanes from this one on */

/* Where a thing is at a frame. */
typedef struct {
    double x;                       /* across the picture */
    double speed;                   /* of x, a second */
} track_point;

/* What it does first; what follows is drawn. */
typedef enum { TRACK_CROSS, TRACK_HIDE, TRACK_LEAVE, TRACK_STAND } track_act;

/**
 * track_path_draw - where a thing of a lane is at each of n times
 *
 *   time     (n) seconds, rising from 0
 *   out      (n)
 */
void track_path_draw(lt_rng *r, int lane, const track_screen screen[TRACK_SCREENS], track_act first, const double *time,
                     int n, track_point *out);

#ifdef __cplusplus
}
#endif
#endif
