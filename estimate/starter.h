/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The small models that come with palmar, for who has none: a folder of weights, each with a card, NAME.json beside
 * NAME.safetensors, that says what it is for, how it was trained and what it is worth.
 */
#ifndef ESTIMATE_STARTER_H
#define ESTIMATE_STARTER_H

#include "libtensor/base/arena.h"

#ifdef __cplusplus
extern "C" {
#endif

struct cJSON;

/* What one is for: a card's "role" */
#define STARTER_DETECTOR "detector"                 /* finds hands and objects */
#define STARTER_COLOUR "hand-object"                /* poses from a colour image */
#define STARTER_DEPTH "hand-object-depth"           /* from colour and depth */

/**
 * starter_folder - where they are: what PALMAR_STARTER names, else models/starter of root, the folder of what comes
 * with palmar. In arena memory; NULL: none left
 */
const char *starter_folder(lt_arena *arena, const char *root);

/**
 * starter_cards - what is there, a list of cards by name; each has "path" and "bytes" of its weights added
 *
 * The caller deletes *out. Errors: LT_EIO: no such folder or no card in it, with a line that says how to make them;
 * LT_EFORMAT: a card that is none, or has no weights beside it.
 */
lt_status starter_cards(lt_arena *arena, const char *folder, struct cJSON **out);

/* starter_find - the weights of the first one with this role, in arena memory. Errors as starter_cards. */
lt_status starter_find(lt_arena *arena, const char *folder, const char *role, const char **out);

#ifdef __cplusplus
}
#endif
#endif
