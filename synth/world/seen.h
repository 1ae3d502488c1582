/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What of each thing a picture shows. A person's is all of him: his hands too, which are things of their own besides.
 */
#ifndef SYNTH_WORLD_SEEN_H
#define SYNTH_WORLD_SEEN_H

#include "synth/world/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Pixels; x1 and y1 are one past the last. All zero: none. */
typedef struct { int x0, y0, x1, y1; } synth_pixels;

/* synth_pixels_of - the box around what is not 0 in a mask (height, width), and its pixels */
synth_pixels synth_pixels_of(const uint8_t *mask, int width, int height, int64_t *n);

typedef struct {
    const uint8_t *mask;            /* (height, width) 1 where the thing is seen */
    int64_t visible, whole;         /* pixels that show it, and that would if nothing else were there */
    synth_pixels box, whole_box;    /* around these */
    bool cut;                       /* what is seen of it ends at the picture's border, and it goes on */
} synth_seen;

/* synth_seen_share - of the pixels that it would have, those that it has; 0 outside the picture */
static inline double synth_seen_share(const synth_seen *s)
{
    return s->whole ? (double)s->visible / (double)s->whole : 0;
}

/**
 * synth_world_cover - mark the pixels that a thing would cover if nothing stood before it: its amodal mask
 *
 *   mask     (height, width) of the camera's picture: 1 where the thing is, other pixels keep their value
 *   cut      becomes true where it goes on past the border; else it keeps its value
 *
 * Whoever begins with the mask of what is seen has a mask that holds it. Errors: LT_ENOMEM.
 */
lt_status synth_world_cover(lt_arena *arena, const synth_world *w, const synth_camera *camera, int thing, uint8_t *mask,
                            bool *cut);

/**
 * synth_world_look - measure a world's picture
 *
 *   frame    what synth_render drew of it
 *   wanted   the things that are measured; NULL: all
 *   out      (n_things) in the arena; zero where they are not wanted
 *
 * Errors: LT_ENOMEM.
 */
lt_status synth_world_look(lt_arena *arena, const synth_world *w, const synth_camera *camera, const synth_frame *frame,
                           bool (*wanted)(const synth_thing *thing), synth_seen **out);

#ifdef __cplusplus
}
#endif
#endif
