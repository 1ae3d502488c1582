/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Hands as they stand in a scene, left and right, bare or around an object, each with an arm.
 *
 * A left hand is a right one in the mirror: it holds what a right hand holds the mirror image of.
 */
#ifndef SYNTH_WORLD_GRIP_H
#define SYNTH_WORLD_GRIP_H

#include "synth/take/prop.h"
#include "synth/take/subject.h"
#include "synth/world/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A posed hand, in the frame of what it holds or in one of its own. */
typedef struct {
    bool left;
    const synth_prop *prop;                     /* NULL: a bare hand */
    double pose[3 * LT_HAND_JOINTS];            /* axis-angle, of a right hand: a left one is its mirror image in x */
    double vertices[LT_HAND_VERTICES][3];
    double wrist[3], elbow[3];                  /* the wrist's place; a unit vector from there */
} synth_grip;

/* An object and its mirror image, for both hands. */
typedef struct { synth_prop right, left; } synth_prop_pair;

/* synth_grip_hold - a grasp of the object by the subject, a function of seed; LT_ENOMEM, LT_ENUMERIC: none was found */
lt_status synth_grip_hold(const lt_hand_model *hand, const synth_subject *who, const synth_prop_pair *what, bool left,
                          uint64_t seed, synth_grip *out);

/* synth_grip_bare - a hand that holds nothing: open, pointing, at rest, or closed more or less */
void synth_grip_bare(const lt_hand_model *hand, const synth_subject *who, bool left, lt_rng *rng, synth_grip *out);

/* synth_grip_turn - the rotation of the grip's frame that brings its elbow's direction to `along` (a unit vector), and
 * turns it about that by roll radians from where `side` is, which is not along it; NULL: from anywhere, which jumps
 * where `along` turns */
void synth_grip_turn(const synth_grip *g, const double along[3], const double *side, double roll, double R[9]);

/* A grip in a world. */
typedef struct {
    const lt_hand_model *hand;                  /* right */
    const synth_subject *who;
    const synth_grip *grip;
    double R[9], t[3];                          /* x_world = R x_grip + t */
    double elbow[3];                            /* world: unit, where the arm goes from the wrist */
    double arm;                                 /* metres of it */
    synth_texture *cloth;                       /* of its sleeve */
    bool far;                                   /* few pixels wide */
    int owner;                                  /* the person among the world's things whose the arm is; -1: none */
    int identity, object_identity;
    uint64_t seed, stream;                      /* of the sleeve's folds */
} synth_held;

/* synth_held_place - the hand, the arm and what it holds become part of the world; meshes live in the arena.
 * LT_ENOMEM. */
lt_status synth_held_place(lt_arena *arena, const synth_held *h, synth_world *w);

/* synth_object_place - an object as a thing of the world */
void synth_object_place(const synth_prop *prop, const double R[9], const double t[3], int identity, synth_world *w);

#ifdef __cplusplus
}
#endif
#endif
