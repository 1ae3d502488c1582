/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How people stand and sit about a table: joint angles within the limits, arms that reach, hang or rest, hands bare or
 * around an object.
 */
#ifndef SYNTH_BODY_STANCE_H
#define SYNTH_BODY_STANCE_H

#include "assets/body/body.h"
#include "synth/world/grip.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    bool sits;
    double R[BODY_JOINTS][9];                   /* the pelvis's in the world: x_world = R x_body, then z is up */
    double shape[BODY_DIRECTIONS];
    double trans[3];                            /* of lt_rig_pose */
    double seat[3];                             /* world: on the floor under the pelvis */
    double facing;                              /* radians about z: to (cos, sin) */
    const synth_grip *grip[2];                  /* left, right */
    double object_R[2][9], object_t[2][3];      /* where what they hold is; x_world = R x_object + t */
} synth_body_stance;

/* What there is to stand about, and to hold. */
typedef struct {
    const synth_body *body;
    const double *table;                        /* x0 y0 x1 y1 of its top, at z = 0 */
    double floor;                               /* z */
    const synth_grip *grip[2];                  /* (n_grips[side]) left, right: of the body's hands */
    int n_grips[2];
} synth_body_place;

/**
 * synth_stance_draw - someone at the table
 *
 *   shape    (BODY_SHAPES)
 *
 * All angles are within synth_body_limits, no hand is below the table's top; where no reach of many is so, the arm
 * hangs down. Nearly half of the hands that do not hang hold something.
 */
void synth_stance_draw(const synth_body_place *place, const double *shape, lt_rng *rng, synth_body_stance *out);

#ifdef __cplusplus
}
#endif
#endif
