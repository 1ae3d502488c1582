/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A hand that reaches for an object, takes it, turns it about in the air and puts it back, once or several
 * times: poses of both at 30 frames a second, smooth enough for a camera to follow.
 *
 * World axes are the room's: z up, the table's top at z = 0, the action above the origin; metres.
 */
#ifndef SYNTH_TAKE_SEQUENCE_H
#define SYNTH_TAKE_SEQUENCE_H

#include "libtensor/base/rng.h"
#include "synth/grasp/grasp.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    SYNTH_REACH, SYNTH_CLOSE, SYNTH_LIFT, SYNTH_MANIPULATE, SYNTH_PLACE, SYNTH_RELEASE,
} synth_phase;

/* One thirtieth of a second. */
typedef struct {
    synth_phase phase;
    int round;                              /* which time the object is taken: 0, 1 ... */
    double R_hand[9], wrist[3];             /* the root joint's rotation and place in the world */
    double fingers[45];                     /* axis-angle, joints 1 .. 15 */
    double R_obj[9], t_obj[3];              /* x_world = R x_model + t */
} synth_moment;

typedef struct {
    int n;
    const synth_moment *moment;
    bool held;                              /* in the hand from the first moment to the last: this grasp
                                               cannot be taken from a table */
} synth_sequence;

/* What may happen from one moment to the next. */
#define SYNTH_MAX_STEP 0.025                /* metres, of any joint */
#define SYNTH_MAX_TURN 0.2094               /* radians, of hand or object: 12 degrees */

typedef struct {
    const synth_grasp *grasp;               /* in the object's frame */
    double rest_wrist[3];                   /* lt_hand_rest_wrist for the hand's shape */
    const lt_mesh *object;                  /* model frame; stands on its lowest vertex */
    int min_moments;                        /* at least so many, and at least 48 */
    bool steady;                            /* held things do not slide, fingers do not tremble */
    uint64_t seed, stream;
} synth_sequence_spec;

/**
 * synth_sequence_new - a function of spec alone
 *
 * The moments live in the arena. Errors: LT_ENOMEM.
 */
lt_status synth_sequence_new(lt_arena *arena, const synth_sequence_spec *spec, synth_sequence *out);

/**
 * synth_sequence_join - n sequences one after the other, as rounds of one: nothing is filmed between them
 *
 * The moments live in the arena. Errors: LT_ENOMEM.
 */
lt_status synth_sequence_join(lt_arena *arena, const synth_sequence *part, int n, synth_sequence *out);

/* synth_round_stream - what round i of a take draws from, where round 0 draws from `stream` */
static inline uint64_t synth_round_stream(uint64_t stream, int i)
{
    return i ? lt_rng_mix(stream, (uint64_t)i) : stream;
}

/* synth_fits_table - whether the grasp can be taken while the object stands: hand and forearm stay above
 * the table */
bool synth_fits_table(const synth_sequence_spec *spec);

#ifdef __cplusplus
}
#endif
#endif
