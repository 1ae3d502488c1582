/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A body that goes where it is told: trunk and head by angles, feet and hands to places, by inverse kinematics of legs
 * and arms within the limits of the joints. No memory of what was before: smooth goals give smooth poses.
 */
#ifndef SYNTH_BODY_FOLLOW_H
#define SYNTH_BODY_FOLLOW_H

#include "assets/body/body.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Who follows; the model must outlive it. */
typedef struct {
    lt_rig rig;
    double shape[BODY_DIRECTIONS];
    double rest[BODY_JOINTS][3];                /* joints of the shape at rest */
    double stature, ankle;                      /* metres: from crown to sole, from ankle to sole */
} synth_follower;

void synth_follower_init(const synth_body *body, const double shape[BODY_SHAPES], synth_follower *out);

/* World axes, z up; left is side 0. Radians. */
typedef struct {
    double pelvis[2], floor;                    /* over which point of which floor it is */
    double facing;                              /* about z: to (cos, sin) */
    double lean, twist, sway;                   /* of the trunk: forward, to the left, to the right */
    double look, nod;                           /* of the head: to the left, down */
    double foot[2][2], lift[2], heading[2];     /* where ankles are, how far soles are off the floor, facing of feet */
    double wrist[2][3], hand[2][9];             /* the wrist's place, and its joint's frame */
    bool turned;                                /* hands turn by `turn`, and not to `hand` */
    double turn[2][3];                          /* a pose's, or a mean of several */
    double elbow[2][3];                         /* the side to which elbows bend */
    double fingers[2][3 * LT_HAND_JOINTS];      /* axis-angle, of a right hand, as a grip's; not the first three */
} synth_body_goal;

typedef struct {
    double R[BODY_JOINTS][9], trans[3];         /* of lt_rig_pose */
    double joint[BODY_JOINTS][3];
    double world[BODY_JOINTS][9];               /* frames of joints */
    double turn[2][3];                          /* of hands against untwisted forearms: twist, about y, about z */
} synth_body_pose;

/* synth_follow - as near to the goal as its limbs are long and its joints bend */
void synth_follow(const synth_follower *who, const synth_body_goal *goal, synth_body_pose *out);

#ifdef __cplusplus
}
#endif
#endif
