/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A scene of things that are told apart: persons, hands and objects among furniture. Each is one or more meshes under
 * a label of its own, so that a picture of the scene says of every pixel whose it is.
 *
 * World axes are the room's: z up, metres.
 */
#ifndef SYNTH_WORLD_WORLD_H
#define SYNTH_WORLD_WORLD_H

#include "assets/ycb/ycb.h"
#include "synth/room/room.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Kinds of things: a detector's classes. An object's is SYNTH_HAND_THING + its YCB number. */
enum { SYNTH_PERSON_THING, SYNTH_HAND_THING, SYNTH_CLASSES = 2 + YCB_COUNT };

enum { SYNTH_THINGS = 48, SYNTH_WORLD_INSTANCES = 288 };

typedef struct {
    int kind;
    int owner;                      /* of a hand: its person's place in the list, -1: of nobody who is in the scene */
    bool left;                      /* of a hand */
    int identity;                   /* the same in all frames of a film */
} synth_thing;

typedef struct {
    synth_instance instance[SYNTH_WORLD_INSTANCES];     /* labelled 1 + its thing, 0: of none */
    int n_instances;
    synth_thing thing[SYNTH_THINGS];
    int n_things;
} synth_world;

/* synth_world_thing - one more, whose instances follow; its place in the list, -1 where all are taken */
int synth_world_thing(synth_world *w, const synth_thing *thing);

/* synth_world_place - what is drawn of a thing (-1: of none); its label becomes the thing's. Left out where the thing
 * found no place. Meshes and textures must outlive the world. */
void synth_world_place(synth_world *w, int thing, const synth_instance *in);

/* synth_world_room - begin with a room's furniture; w is empty before */
void synth_world_room(synth_world *w, const synth_room *room);

/* synth_world_scene - what the renderer takes: the world under a room's light; both must outlive it */
synth_scene synth_world_scene(const synth_world *w, const synth_room *room, const synth_camera *camera);

/* synth_class_name - "person", "hand", and the objects' names as YCB has them */
const char *synth_class_name(int kind);

#ifdef __cplusplus
}
#endif
#endif
