/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A person's pose in few numbers, and its 65 joints (data/action/action.h) by inverse kinematics of arms and legs.
 *
 * World: x right, y down, z forward as the person stands, the floor at y = 0, metres; the robot is forward. In a pose,
 * places are seen by the person: out to the arm's own side, up from the floor, forward, in units of the stature.
 */
#ifndef SYNTH_ACTIONS_BODY_H
#define SYNTH_ACTIONS_BODY_H

#include "data/action/action.h"

enum { LEFT, RIGHT, SIDES };
enum { FINGERS = 5 };               /* thumb first */

typedef struct {
    double wrist[3];                /* out, up, forward */
    double palm[3];                 /* where it looks: out, up, forward */
    double bend[FINGERS];           /* of a finger: 0 straight, 1 in a fist */
} arm_pose;

typedef struct {
    double place[2];                /* of the pelvis: x, z in metres */
    double yaw, lean, twist, sway;  /* radians: of all; the trunk's forward, about itself, to the right */
    double turn, nod;               /* the head's, to the right and down */
    arm_pose arm[SIDES];
    double foot[SIDES][2];          /* forward of the standing place, up from it, in statures */
} body_pose;

/* A hand, and its axes as columns: along the fingers, to the thumb, out of the palm; of a right hand they mirror */
typedef struct { double wrist[3], R[9]; } hand_frame;

/* body_joints - the joints in the world, and where the hands are */
void body_joints(const body_pose *pose, double stature, double joint[ACTION_BODY][3], hand_frame hand[SIDES]);

#endif
