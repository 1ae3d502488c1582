/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One clip: a program on a subject's skeleton, with what a difficulty adds: joints that are off, an object that is
 * missed. A clip is a function of its numbers and the seed.
 */
#ifndef SYNTH_ACTIONS_CLIP_H
#define SYNTH_ACTIONS_CLIP_H

#include "data/action/action.h"

#include <stdint.h>

enum { CLIP_FRAMES = 90 };          /* at most */

typedef struct {
    int subject, cls, repetition;
} clip_number;

/* Of CLIP_FRAMES frames; what is behind the last one is zeros. */
typedef struct {
    int frames, onset;              /* onset: the frame in which the act begins */
    float *body;                    /* (3, CLIP_FRAMES, 65) */
    float *hand_object;             /* (3, CLIP_FRAMES, 30), zeros where valid is 0 */
    uint8_t *valid;                 /* (CLIP_FRAMES) */
} clip;

void clip_make(uint64_t seed, double difficulty, const clip_number *number, clip *out);

#endif
