/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Clips of four actions out of DexYCB, in whose takes a hand reaches for an object on the table, picks it up and hands
 * it over: cut where the hand touches the object, and where that leaves its place.
 *
 * Source: Bandi and Thomas 2025, section 5: reaching ends with contact, picking up runs from half a second before it to
 * a second after the object has left its place, handing over from half a second after that; placing is picking up
 * backwards. Distances are the specification's.
 */
#ifndef DATA_ACTION_TAKES_H
#define DATA_ACTION_TAKES_H

#include "data/action/action.h"
#include "data/dataset.h"

#ifdef __cplusplus
extern "C" {
#endif

/* action_is_takes - whether root is DexYCB's */
bool action_is_takes(const char *root);

/**
 * action_open_takes - the clips of all takes that are there, as one camera of each sees them, into the arena
 *
 *   hand     the right hand that the data were made with: its surface is measured
 *
 * Joints and objects are in the camera's axes, of left hands in the mirror; frames without a hand are not valid.
 * Nobody's skeleton is known: out->no_body, and body is zeros. A take in which the hand touches nothing, or nothing
 * leaves its place, is left out.
 *
 * Errors: those of opening DexYCB and of its labels; no clip is left. LT_ENOMEM.
 */
lt_status action_open_takes(lt_arena *arena, const char *root, const lt_hand_model *hand, action_set *out);

/* What a take is cut by: frames, -1 where it never happens */
typedef struct { int touched, left, frames; } action_take;

typedef struct {
    int cls, first, last;           /* frames, both of the clip */
    bool backwards;
} action_cut;

enum { ACTION_CUTS = 4 };

/* action_cut_take - its clips; how many: 4, or 0 */
int action_cut_take(const action_take *take, action_cut out[ACTION_CUTS]);

#ifdef __cplusplus
}
#endif
#endif
