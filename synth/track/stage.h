/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The places of films for trackers: a hall in which persons walk, a table over which hands and objects move. Lanes lie
 * across the view, one behind the other; two screens stand between them.
 */
#ifndef SYNTH_TRACK_STAGE_H
#define SYNTH_TRACK_STAGE_H

#include "synth/room/room.h"
#include "synth/track/path.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { TRACK_WIDTH = 512, TRACK_HEIGHT = 288 };

typedef struct {
    synth_room *room;                           /* all its textures are painted */
    synth_camera camera;
    double lane[TRACK_LANES];                   /* y */
    double half[TRACK_LANES];                   /* metres from the middle of the view to its border */
    track_screen screen[TRACK_SCREENS];
} track_stage;

/* track_hall_new, track_table_new - a function of seed and stream; lives in the arena. LT_ENOMEM. */
lt_status track_hall_new(lt_arena *arena, uint64_t seed, uint64_t stream, track_stage *out);
lt_status track_table_new(lt_arena *arena, uint64_t seed, uint64_t stream, track_stage *out);

#ifdef __cplusplus
}
#endif
#endif
