/* SPDX-License-Identifier: Apache-2.0 */
/* What is true of a frame, as truth.ndjson and world.json have it (docs/formats.md). */
#ifndef SYNTH_WORKPLACE_TRUTH_H
#define SYNTH_WORKPLACE_TRUTH_H

#include "synth/workplace/clock.h"
#include "synth/workplace/scene.h"
#include "synth/world/seen.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What the cameras saw of each thing; NULL for one that lost the frame. */
typedef struct { const synth_seen *seen[RECORDING_CAMERAS]; } workplace_views;

/* What a frame adds to stats.json. */
typedef struct {
    double miss;                    /* metres: of wrists, the sum */
    int wrists;
    double seen;                    /* share of persons in the first camera, the sum */
    int people;                     /* of whom it saw some */
    int held, touched;              /* objects in hands, and of these in contact */
} workplace_tally;

/* truth_contact - metres from the surface of an object to the skin of a hand: negative inside */
double truth_contact(const workplace_scene *scene, int person, int side, int object);

/* truth_print - a line's keys from "tracks" on, without the last brace and newline */
void truth_print(FILE *f, const workplace_scene *scene, const recording_rig *rig, const workplace_views *views,
                 workplace_tally *tally);

/* truth_world - write world.json: who and what there is, light, clocks. LT_EIO, LT_ENOMEM. */
lt_status truth_world(const char *path, const workplace_script *s, const synth_room *room, const recording_rig *rig,
                      const workplace_clock *clock, const synth_sensor *sensor);

#ifdef __cplusplus
}
#endif
#endif
