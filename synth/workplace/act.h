/* SPDX-License-Identifier: Apache-2.0 */
/* What a script says of one person at a moment, for those who write it. Private to this folder. */
#ifndef SYNTH_WORKPLACE_ACT_H
#define SYNTH_WORKPLACE_ACT_H

#include "synth/workplace/script.h"

/* Classes as data/action/action.h numbers them */
enum {
    ACT_WAVE, ACT_WALK, ACT_REACH, ACT_CROSS, ACT_POINT, ACT_WAIT, ACT_RECEIVE, ACT_PLACE, ACT_HAND_OVER, ACT_PICK,
};

enum { ACT_GAP = 16 };              /* frames from a program to the next */

/* act_ease - 0 at from, 1 at to, with minimum jerk */
double act_ease(double k, double from, double to);

/* act_turn - the rotation a share of the way from A to B, the shorter way round */
void act_turn(const double A[9], const double B[9], double share, double out[9]);

/* act_goal - what the programs want of the body at frame k; without holds where `bare` */
void act_goal(const workplace_script *s, const workplace_person *p, int k, bool bare, synth_body_goal *out);

/* act_follow - a body at a goal, its hands out of the table */
void act_follow(const workplace_script *s, const workplace_person *p, const synth_body_goal *goal, double clear,
                synth_body_pose *out);

/* act_target - the draw's target that brings the wrist of its arm to `wrist` at frame k */
void act_target(const workplace_person *p, workplace_act *act, int k, const double wrist[3]);

/* act_blend - where something is on the way from a to b */
void act_blend(const synth_settled *a, const synth_settled *b, double share, synth_settled *out);

/* act_in_hand - where the hand that has objects has what it grasps */
void act_in_hand(const workplace_person *p, const synth_body_pose *body, synth_settled *out);

/* act_meets, act_leaves - the first frame in which the hand has the object, and has it no more */
int act_meets(const workplace_act *a);
int act_leaves(const workplace_act *a);

#endif
