/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where errors lie: mean errors of each joint, of each object, of each sequence.
 */
#ifndef TASKS_HAND_OBJECT_BREAKDOWN_H
#define TASKS_HAND_OBJECT_BREAKDOWN_H

#include "libtensor/base/arena.h"
#include "libtensor/base/status.h"
#include "libtensor/geometry/hand/model.h"

typedef struct eval_breakdown eval_breakdown;

/* One sample's: points in any axes, metres, wrist first. */
typedef struct {
    const char *name;               /* "ABF10/0123": its sequence is what stands before the last slash */
    const char *object;             /* NULL: none, then add and add01 are not looked at */
    const double *joints, *truth;   /* (21, 3) */
    double add;                     /* of the object; infinite without a pose */
    bool add01;                     /* whether it is right by ADD-0.1D */
} eval_breakdown_sample;

/* eval_breakdown_new - empty, in the arena; NULL without memory */
eval_breakdown *eval_breakdown_new(lt_arena *arena);

/* eval_breakdown_add - in any order, but the same order gives the same bits. LT_ENOMEM */
lt_status eval_breakdown_add(eval_breakdown *b, const eval_breakdown_sample *s);

/**
 * eval_breakdown_write - per-joint.csv, per-object.csv, per-sequence.csv in folder
 *
 * pa_mpjpe_mm: after the similarity that fits the sample's 21 joints best, reflections allowed, as HO3D has it.
 * mpjpe_mm: wrist on wrist. Objects and sequences besides: add_mm, add01_percent and the number of samples. A mean
 * over a sample without a finite answer is left empty.
 * Errors: those of lt_csv_open and lt_csv_commit.
 */
lt_status eval_breakdown_write(const eval_breakdown *b, const char *folder);

#endif
