/* SPDX-License-Identifier: Apache-2.0 */
/* Things that stand about on tables. */
#ifndef SYNTH_ROOM_CLUTTER_H
#define SYNTH_ROOM_CLUTTER_H

#include "libtensor/base/rng.h"
#include "synth/room/room.h"

enum { CLUTTER_PARTS = 4 };

/* One thing: its parts, standing on z = 0 around the z axis, and the radius it needs. */
typedef struct {
    synth_instance part[CLUTTER_PARTS];
    int n_parts;
    double radius;
} clutter;

/* clutter_make - something at random; false without memory */
bool clutter_make(lt_arena *arena, lt_rng *r, clutter *out);

#endif
