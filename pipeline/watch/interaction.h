/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a person and the objects are about: nobody near, reaching, touching, holding, giving, taking, putting down. By
 * rules over contact, motion and action, with no network of its own.
 *
 * Source: Bandi and Thomas 2025, the handover interaction state; the rules are ours.
 */
#ifndef PIPELINE_WATCH_INTERACTION_H
#define PIPELINE_WATCH_INTERACTION_H

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    INTERACTION_NONE, INTERACTION_APPROACH, INTERACTION_CONTACT, INTERACTION_HOLD, INTERACTION_HANDOVER,
    INTERACTION_RECEIVE, INTERACTION_PLACE, INTERACTION_STATES,
} interaction_state;

extern const char *const interaction_names[INTERACTION_STATES];

/* What is seen of a person in a set. Metres, seconds; NaN where something is not known. */
typedef struct {
    double t;
    int action;                     /* class, -1: not known */
    double p;                       /* its probability */
    int64_t object;                 /* that a hand touches, else the one nearest to a wrist; 0: none */
    bool left;                      /* the hand that does or would */
    bool contact;
    double contact_since;
    double reach;                   /* from the wrist to that object's side */
    double object_speed;
    double slip;                    /* how fast the object moves in the hand: difference of their velocities */
    double lift;                    /* of the object over where it stood last */
    double robot;                   /* from the wrist to the robot's side, below 0 in it */
    double robot_speed;             /* of the wrist towards it */
    double flexion_deg;             /* of the fingers, mean */
} interaction_seen;

enum { INTERACTION_PAST = 16 };

/* Zeroed at first. */
typedef struct {
    interaction_state state, next;
    int agreed;                     /* sets in a row that say next */
    double since;
    int64_t object;
    bool left, lifted;              /* lifted: what is touched has been off its support since it is */
    double p;
    struct { double t, reach; } past[INTERACTION_PAST];         /* of the last sets, a ring */
    int64_t n_past;
} interaction;

/* interaction_step - the next set of frames; s->state is what holds then. A change needs three sets in a row. */
void interaction_step(interaction *s, const interaction_seen *seen);

#endif
