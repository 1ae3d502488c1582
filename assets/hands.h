/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The hand models of a run: MANO's files where they are, the embedded hand elsewhere.
 */
#ifndef ASSETS_HANDS_H
#define ASSETS_HANDS_H

#include "libtensor/base/arena.h"
#include "libtensor/base/status.h"
#include "libtensor/geometry/hand/model.h"

typedef struct {
    lt_hand_model *right;
    lt_hand_model *left;            /* as its file has it; NULL: there is none, take the right one's mirror image */
    const char *name;               /* of the file of the right hand, or "embedded synthetic hand" */
    const char *path;               /* what names the same hands again, whatever $PALMAR_HAND says then */
} hands;

/**
 * hands_open - both hands, in the arena
 *
 *   path     MANO_RIGHT.pkl, MANO_LEFT.pkl, the same as .npz, or the folder of the two; "embedded": the embedded
 *            hand; NULL or "": what $PALMAR_HAND names; without that the embedded hand
 *
 * The other side's file is taken from the same folder where it is. With a left file alone the right hand is
 * its mirror image, the sign of its shape directions' x put right first (hand_left_is_flipped: the released
 * file has it wrong).
 * Errors: those of hand_file_read; a file that is not there names the page that offers it.
 */
lt_status hands_open(lt_arena *arena, const char *path, hands *out);

/* hands_are_embedded - the embedded hand, not somebody's file */
bool hands_are_embedded(const hands *h);

/* hands_note - one line that says how to have the real hand instead of the embedded one */
const char *hands_note(void);

#endif
