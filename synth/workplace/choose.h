/* SPDX-License-Identifier: Apache-2.0 */
/* How somebody grasps an object on the table: of many grasps, turns of the object and places, one that the arm reaches
 * within its limits. Private to this folder. */
#ifndef SYNTH_WORKPLACE_CHOOSE_H
#define SYNTH_WORKPLACE_CHOOSE_H

#include "synth/workplace/script.h"

/* choose_grasp - sets the person's grip, where the object stands before, and how he picks it up: the frame of the
 * wrist, its place, how much farther he leans. *found: whether there is such a grasp. LT_ENOMEM. */
lt_status choose_grasp(const workplace_script *s, workplace_person *p, workplace_object *o, lt_rng *r,
                       workplace_hold *how, double *lean, bool *found);

/* choose_wrist - where the wrist is, and its frame, to hold what stands at `at` */
void choose_wrist(const workplace_person *p, const synth_settled *at, double wrist[3], double hand[9]);

/* choose_miss - metres, and a tenth of radians, that the hand is off a place in frame k of an act that goes there */
double choose_miss(const workplace_script *s, const workplace_person *p, const workplace_act *act, int k,
                   const double wrist[3], const double hand[9]);

#endif
