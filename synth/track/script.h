/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One film for trackers: who is in it, and what is where at each of its frames.
 */
#ifndef SYNTH_TRACK_SCRIPT_H
#define SYNTH_TRACK_SCRIPT_H

#include "synth/track/stage.h"
#include "synth/world/grip.h"
#include "synth/world/person.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Persons: of each ten, twins are some that have another's shape and clothes of their own, or the reverse. */
enum {
    TRACK_FILMS = 20, TRACK_HALLS = 14,         /* the others are tables */
    TRACK_TRAIN_HALLS = 9, TRACK_TRAIN_TABLES = 3,
    TRACK_TRAIN_PEOPLE = 32, TRACK_NEW_PEOPLE = 10,
    TRACK_PEOPLE = TRACK_TRAIN_PEOPLE + TRACK_NEW_PEOPLE,
    TRACK_DROPS = 3,
};

/* Somebody, or somebody's hand and what it holds. */
typedef struct {
    int lane, identity;                         /* of the person */
    synth_person person;
    synth_grip grip[2];                         /* left, right; of a hand that is alone [left ? 0 : 1] */
    bool left;                                  /* which hand that is */
    double phase, roll;                         /* of sway; of the hand */
    const track_point *path;
    const double *stride;                       /* radians of his gait so far */
} track_actor;

typedef struct {
    bool hall, evaluation;
    char name[16];                              /* "hall-01" */
    const lt_hand_model *hand;
    const synth_prop_pair *prop;
    uint64_t seed;
    int frames;
    const double *time;                         /* seconds */
    track_stage stage;
    track_actor actor[TRACK_LANES];
} track_script;

/* track_identity - a person by number: the number of his shape, and that of his clothes */
void track_identity(int number, int *body, int *clothes);

/* track_script_new - film `number` of a seed; hand, prop, seed and frames are set. Lives in the arena. LT_ENOMEM. */
lt_status track_script_new(lt_arena *arena, int number, track_script *s);

/* track_script_pose - the world at frame k; meshes live in the arena. LT_ENOMEM. */
lt_status track_script_pose(lt_arena *arena, const track_script *s, int k, synth_world *w);

#ifdef __cplusplus
}
#endif
#endif
