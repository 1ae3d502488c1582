/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures of one person each, as a network for whole bodies is given them: the part of a wider picture that a
 * detector's box, made 3:4 and larger by a quarter, takes in. Some twenty are taken in one place.
 */
#ifndef SYNTH_BODY_CROP_H
#define SYNTH_BODY_CROP_H

#include "data/body/set.h"
#include "synth/body/appearance.h"
#include "synth/body/stance.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    SYNTH_BODY_PEOPLE = 3, SYNTH_BODY_GRIPS = 8,
    SYNTH_BODY_LOOK_WIDTH = 160, SYNTH_BODY_LOOK_HEIGHT = 120,
};

typedef struct {
    const synth_body *body;
    const lt_hand_model *hand;
    const synth_prop_pair *prop;                /* (YCB_COUNT) by number less one */
    uint64_t seed;
    int64_t number;
    const synth_room *room;                     /* all its textures are painted */
    synth_appearance look[SYNTH_BODY_PEOPLE];
    double shape[SYNTH_BODY_PEOPLE][BODY_SHAPES];
    synth_grip grip[2][SYNTH_BODY_GRIPS];       /* left, right */
    int n_grips[2];
} synth_crop_place;

/* synth_crop_place_new - place number n; lives in the arena. body, hand, prop, seed, number are set. LT_ENOMEM. */
lt_status synth_crop_place_new(lt_arena *arena, synth_crop_place *p);

/**
 * synth_crop_take - picture number i of the dataset, a function of the place and i
 *
 *   small    SYNTH_BODY_LOOK_WIDTH x SYNTH_BODY_LOOK_HEIGHT, to look for the person in
 *   frame    BODY_PICTURE_WIDTH x BODY_PICTURE_HEIGHT; rgb is set
 *
 * Errors: LT_ENOMEM.
 */
lt_status synth_crop_take(lt_arena *arena, const synth_crop_place *place, int64_t i, synth_frame *small,
                          synth_frame *frame, body_row *out);

#ifdef __cplusplus
}
#endif
#endif
