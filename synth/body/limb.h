/* SPDX-License-Identifier: Apache-2.0 */
/* Arms and hands of the synthetic body: joints from places. Left is side 0. */
#ifndef SYNTH_BODY_LIMB_H
#define SYNTH_BODY_LIMB_H

#include "assets/body/body.h"
#include "synth/world/grip.h"

#ifdef __cplusplus
extern "C" {
#endif

/* synth_limb_aim - an arm from the shoulder over the elbow to the wrist, the hinge across both; collar is the collar's
 * frame in the world, the elbow bends about y alone */
void synth_limb_aim(int side, const double collar[9], const double shoulder[3], const double elbow[3],
                    const double wrist[3], double R_shoulder[9], double R_elbow[9]);

/* synth_limb_fingers - a grip's pose becomes joints of the hand among all of the body's, R: (BODY_JOINTS); a left hand
 * is its mirror image */
void synth_limb_fingers(int side, const double pose[3 * LT_HAND_JOINTS], double (*R)[9]);

/* synth_limb_object - where what the grip holds is, of where the wrist is: x_world = R x_object + t */
void synth_limb_object(int side, const synth_grip *g, const double wrist_R[9], const double wrist[3], double R[9],
                       double t[3]);

#ifdef __cplusplus
}
#endif
#endif
