/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Takes away the things on a table that a hand, its arm or what it holds would pass through.
 */
#ifndef SYNTH_TAKE_CLEARING_H
#define SYNTH_TAKE_CLEARING_H

#include "synth/room/room.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Something that is, at some moment, at this place. */
typedef struct { double centre[3], radius; } synth_ball;

/* synth_in_way - whether one of n balls meets the upright cylinder from the table at x, y up to top */
bool synth_in_way(double x, double y, double radius, double top, const synth_ball *ball, int n);

/* synth_clear_way - remove from the room what stands in the way of n balls, whole things at a time; tables
 * and walls, which cast no shadow, stay */
void synth_clear_way(synth_room *room, const synth_ball *ball, int n);

#ifdef __cplusplus
}
#endif
#endif
