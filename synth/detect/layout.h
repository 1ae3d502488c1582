/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Who and what is in a picture for detectors, and where the camera stands. Some twenty pictures are taken in one place:
 * a room, and the people who are there.
 */
#ifndef SYNTH_DETECT_LAYOUT_H
#define SYNTH_DETECT_LAYOUT_H

#include "synth/world/grip.h"
#include "synth/world/person.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { DETECT_PEOPLE = 6, DETECT_SIDE = 320 };

typedef struct {
    const lt_hand_model *hand;
    const synth_prop_pair *prop;                /* (YCB_COUNT) by number */
    uint64_t seed;
    double near;                                /* share of pictures that show a hand from near by */
    const synth_room *room;                     /* all its textures are painted */
    synth_person person[DETECT_PEOPLE];
} detect_place;

/* A hand or an object where it was put: x_world = R x + t. */
typedef struct {
    int thing;
    const synth_grip *grip;                     /* of a hand; NULL: an object */
    const synth_subject *who;                   /* of a hand */
    const synth_prop *prop;
    double R[9], t[3];
} detect_put;

typedef struct {
    synth_world world;
    synth_room room;                            /* the place's, without what stands in the way */
    synth_camera camera;
    bool near;                                  /* a hand or two, as large as the picture allows, before the rest */
    detect_put put[SYNTH_THINGS];
    int n_put;
    bool bare[SYNTH_THINGS];                    /* a hand with no object within 5 mm */
} detect_picture;

/* detect_place_new - place number n of a seed; lives in the arena. hand, prop, seed, near are set. LT_ENOMEM. */
lt_status detect_place_new(lt_arena *arena, int64_t n, detect_place *p);

/* detect_lay_out - picture number i of the seed, a function of both; meshes live in the arena. LT_ENOMEM. */
lt_status detect_lay_out(lt_arena *arena, const detect_place *place, int64_t i, detect_picture *out);

/* detect_develop - what was drawn of picture number i as a camera that somebody has would show it: exposure, colour,
 * noise; one picture in four is blurred by motion */
void detect_develop(const detect_place *place, int64_t i, synth_frame *f);

#ifdef __cplusplus
}
#endif
#endif
