/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The ten programs: what somebody does at a moment of a clip, as key poses between which joints move with minimum jerk,
 * and beats upon them. Reaching (2) and receiving (6) run along the same path of the arm, and part by the hand alone.
 */
#ifndef SYNTH_ACTIONS_PROGRAM_H
#define SYNTH_ACTIONS_PROGRAM_H

#include "libtensor/base/rng.h"
#include "synth/actions/body.h"

/* Whose clip it is: drawn once for a subject. */
typedef struct {
    double stature;                 /* metres */
    double speed, amplitude;        /* factors */
    double delay;                   /* share of a clip before anything begins */
    double idle;                    /* factor on what moves while nothing is done */
    int arm;                        /* the preferred one */
} action_style;

/* One repetition: drawn for each clip. */
typedef struct {
    int cls, frames;
    int arm;                        /* that does it: mostly the preferred one */
    double begin;                   /* share of the clip, the first frame of the act */
    double target[3];               /* where the wrist goes: out, up, forward in statures */
    double pace, phase;             /* factor on the rhythm; radians */
    double meets, leaves;           /* shares of the clip: the hand gets the object, and gives it away */
    double parts;                   /* share of the clip before which reaching and receiving are the same */
    double size[3];                 /* of the object, metres */
    double yaw, place[2], wander;   /* of the person; phase of idle motion */
} action_draw;

void action_style_draw(lt_rng *r, action_style *out);

/* action_draw_new - difficulty in [0, 1] says how late reaching and receiving part */
void action_draw_new(lt_rng *r, int cls, double difficulty, const action_style *style, action_draw *out);

/* action_pose - at frame k */
void action_pose(const action_style *style, const action_draw *draw, int k, body_pose *out);

/* action_holds - whether hand and object touch at frame k */
bool action_holds(const action_draw *draw, int k);

#endif
