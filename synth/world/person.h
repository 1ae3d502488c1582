/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Persons as clothed shapes: trunk, legs, upper arms, neck and head; forearms and hands are synth_held's. A stand-in
 * that a detector can learn "person" from, and a tracker whose clothes tell who it is; no body model.
 *
 * Proportions are shares of the stature, of Drillis and Contini 1966.
 */
#ifndef SYNTH_WORLD_PERSON_H
#define SYNTH_WORLD_PERSON_H

#include "synth/take/subject.h"
#include "synth/world/world.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Who somebody is: the same in all pictures. */
typedef struct {
    synth_subject subject;                      /* hand, skin, sleeve */
    double stature, girth;                      /* metres; factor on thickness */
    double hair_length;                         /* radians from the crown down: 1.3 short, 2.4 long */
    float hair[3], shoes[3];                    /* albedo */
    synth_texture *shirt, *trousers;
    uint64_t seed, stream;                      /* of the folds */
} synth_person;

/* What he does. World axes, metres. */
typedef struct {
    double at[3];                               /* on the floor, between the feet or under the seat */
    double facing;                              /* radians about z: he looks along (cos, sin) */
    double lean;                                /* radians that the trunk is bent forward */
    double nod, look;                           /* of the head: radians down, to his left */
    double stride[2];                           /* radians that his left and right leg are before him */
    bool sits;
} synth_stance;

/* Where his arms begin, and how long they are. Left first. */
typedef struct {
    double shoulder[2][3];
    double upper, fore;                         /* metres: shoulder to elbow, elbow to wrist */
    double forward[3], left[3];                 /* unit; up is z */
} synth_reach;

/* synth_person_draw - by numbers: body is his shape, clothes what he wears; LT_ENOMEM. Textures are painted. */
lt_status synth_person_draw(lt_arena *arena, const lt_hand_model *hand, uint64_t seed, int body, int clothes,
                            synth_person *out);

void synth_person_reach(const synth_person *p, const synth_stance *s, synth_reach *out);

/* synth_reach_elbow - the elbow of an arm (0 left, 1 right) whose wrist is at `wrist`; the wrist comes nearer where the
 * arm is too short. swivel: radians that the elbow is turned outwards from hanging down */
void synth_reach_elbow(const synth_reach *r, int arm, double swivel, double wrist[3], double elbow[3]);

/* synth_person_place - his body but for forearms and hands as a thing of the world, its upper arms ending at the
 * elbows; *thing: its place in the list. LT_ENOMEM. */
lt_status synth_person_place(lt_arena *arena, const synth_person *p, const synth_stance *s, double elbow[2][3],
                             int identity, synth_world *w, int *thing);

#ifdef __cplusplus
}
#endif
#endif
