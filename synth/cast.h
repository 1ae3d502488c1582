/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which takes a preset consists of: who handles what, how often, and what is kept for evaluation.
 */
#ifndef SYNTH_CAST_H
#define SYNTH_CAST_H

#include "synth/generate.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { SYNTH_MAX_TAKES = 1000, SYNTH_MAX_OTHERS = 4 };

typedef struct {
    int subject;
    int object;                     /* 1..21 */
    int frames;                     /* that each camera keeps */
    int rounds;                     /* how often the object is taken, with a grasp of its own each time */
    bool evaluation;
    bool left;                      /* DexYCB: a left hand */
    int other[SYNTH_MAX_OTHERS], n_others;      /* DexYCB: 1..21, what else is on the table */
    char base[64];                  /* HO3D: the sequences' name without the camera's digit, "SYN3MB0"; DexYCB: the
                                       sequence's folder, "20260101-subject-01/20260101_100000" */
} synth_take;

typedef struct {
    int n_subjects, n_takes, n_cameras;
    int shrink;                     /* pictures are 640 x 480 over this */
    bool hogs;                      /* hands and objects share no space; light and initial poses are written: hogs.h */
    int object[21], n_objects;
    synth_take take[SYNTH_MAX_TAKES];
} synth_cast;

/**
 * synth_cast_plan - the takes of a preset
 *
 *   frames       in all; 0: the preset's
 *
 * Training and evaluation share no take. Evaluation goes over the four objects of HO3D's, of which the
 * pitcher is never trained on, and where there are subjects enough has some that training has not.
 * Errors: fewer frames than sequences, more than 200 a sequence.
 */
lt_status synth_cast_plan(synth_preset preset, int frames, synth_cast *out);

/**
 * synth_cast_plan_dexycb - the takes of a preset as DexYCB counts them: by subject, object, trial
 *
 *   frames       in all; 0: the preset's
 *
 * Each subject takes each object five times, the fifth for evaluation (s0); half of the takes are left hands.
 * Errors: fewer frames than views, more than 200 each.
 */
lt_status synth_cast_plan_dexycb(synth_preset preset, int frames, uint64_t seed, synth_cast *out);

#ifdef __cplusplus
}
#endif
#endif
