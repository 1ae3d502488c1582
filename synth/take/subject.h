/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The people whose hands are seen: shape of the hand, skin, sleeve; one draw each.
 */
#ifndef SYNTH_TAKE_SUBJECT_H
#define SYNTH_TAKE_SUBJECT_H

#include "assets/hand/hand.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double beta[LT_HAND_BETAS];
    double rest_wrist[3];                       /* of that shape */
    float color[LT_HAND_VERTICES][3];           /* albedo, linear RGB */
    float skin[3];                              /* of the forearm */
    double bare;                                /* metres of forearm before the sleeve */
} synth_subject;

/* synth_subject_draw - person number `number` of the dataset with this seed; shapes stay within 2.5 SD */
void synth_subject_draw(const lt_hand_model *hand, uint64_t seed, int number, synth_subject *out);

/* A posed hand, in whichever axes trans and root were. */
typedef struct {
    double vertices[LT_HAND_VERTICES][3];
    double keypoints[LT_HAND_KEYPOINTS][3];     /* MANO order */
} synth_posed_hand;

/* synth_subject_pose - the subject's hand with the wrist at `wrist`, turned by R, fingers axis-angle */
void synth_subject_pose(const synth_subject *s, const lt_hand_model *hand, const double R[9],
                        const double wrist[3], const double fingers[45], synth_posed_hand *out);

#ifdef __cplusplus
}
#endif
#endif
