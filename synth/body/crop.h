/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures of one person each, as a network for whole bodies is given them: the part of a wider picture that a
 * detector's box, made 3:4 and larger by a quarter, takes in. Some twenty are taken in one place.
 */
#ifndef SYNTH_BODY_CROP_H
#define SYNTH_BODY_CROP_H

#include "synth/body/appearance.h"
#include "synth/body/stance.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    SYNTH_BODY_WIDTH = 192, SYNTH_BODY_HEIGHT = 256, SYNTH_BODY_PEOPLE = 3, SYNTH_BODY_GRIPS = 8,
    SYNTH_BODY_LOOK_WIDTH = 160, SYNTH_BODY_LOOK_HEIGHT = 120,
    SYNTH_BODY_BOXES = 3,                       /* left hand, right hand, face */
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

/* What is written of a picture. Camera axes: x right, y down, z forward; pixels of the picture that is written. */
typedef struct {
    float pose[BODY_JOINTS][3];                 /* axis-angle; the pelvis's in the camera */
    float shape[BODY_SHAPES], expression[BODY_EXPRESSIONS];
    float trans[3];                             /* added to all vertices at the end */
    float K[3][3];
    float nodes_3d[BODY_NODES][3], nodes_2d[BODY_NODES][2];
    uint8_t seen[BODY_NODES];                   /* bit 0: in the picture; bit 1: nothing else is before it */
    float boxes[SYNTH_BODY_BOXES][4];           /* x0 y0 x1 y1 of the vertices; may reach beyond the picture */
    int32_t subject;
    uint8_t holds[2];                           /* left, right: number of the object, 0: none */
    uint8_t cut;                                /* 1: the wider picture's edge cuts the person off */
    uint8_t sits;
} synth_crop_truth;

/* synth_crop_place_new - place number n; lives in the arena. body, hand, prop, seed, number are set. LT_ENOMEM. */
lt_status synth_crop_place_new(lt_arena *arena, synth_crop_place *p);

/**
 * synth_crop_take - picture number i of the dataset, a function of the place and i
 *
 *   small    SYNTH_BODY_LOOK_WIDTH x SYNTH_BODY_LOOK_HEIGHT, to look for the person in
 *   frame    SYNTH_BODY_WIDTH x SYNTH_BODY_HEIGHT; rgb is set
 *
 * Errors: LT_ENOMEM.
 */
lt_status synth_crop_take(lt_arena *arena, const synth_crop_place *place, int64_t i, synth_frame *small,
                          synth_frame *frame, synth_crop_truth *out);

#ifdef __cplusplus
}
#endif
#endif
