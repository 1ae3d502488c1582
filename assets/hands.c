/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/hands.h"

#include "assets/hand/hand.h"
#include "assets/hand_file.h"
#include "libtensor/io/file.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define OFFERED "MANO_RIGHT.pkl and MANO_LEFT.pkl are offered by their authors, after registration, at " \
                "https://mano.is.tue.mpg.de"

static const char EMBEDDED[] = "embedded";

const char *hands_note(void)
{
    return "using the embedded synthetic hand; " OFFERED ", and are named by --hand, data.hand or PALMAR_HAND";
}

/* The hand in a file that is wanted; the line of one that is not there says where to get it. */
static lt_status read_hand(lt_arena *arena, const char *path, lt_hand_model **out)
{
    struct stat s;

    if (stat(path, &s) != 0)
        return lt_error(LT_EIO, "%s: no such file; %s; without it the embedded hand is used", path, OFFERED);
    return hand_file_read(arena, path, out);
}

/* "x/MANO_LEFT.pkl" for "x/MANO_RIGHT.pkl" and back, if there is such a file; NULL otherwise. */
static const char *other_side(lt_arena *arena, const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const char *right = strstr(name, "RIGHT"), *left = strstr(name, "LEFT");
    const char *at = right ? right : left;
    struct stat s;
    char *other;

    if (!at)
        return NULL;
    other = lt_arena_printf(arena, "%.*s%s%s", (int)(at - path), path, right ? "LEFT" : "RIGHT",
                            at + strlen(right ? "RIGHT" : "LEFT"));
    return other && stat(other, &s) == 0 ? other : NULL;
}

/* A right hand out of a left one. Without a right file to compare with, the left one is taken to be as
 * released, its shape directions' x as a right hand has them. */
static lt_status mirrored(lt_arena *arena, const lt_hand_model *left, lt_hand_model **out)
{
    lt_hand_model *fixed = lt_arena_alloc(arena, sizeof(*fixed)), *right = lt_arena_alloc(arena, sizeof(*right));

    if (!fixed || !right)
        return lt_error(LT_ENOMEM, "no memory for the hand model");
    *fixed = *left;
    if (!left->synthetic)
        hand_left_shape(fixed, HAND_LEFT_FIX_X);
    synth_hand_mirror(fixed, right);
    *out = right;
    return LT_OK;
}

static lt_status open_files(lt_arena *arena, const char *path, hands *h)
{
    const char *other;
    lt_hand_model *first, *second = NULL;
    lt_status st;

    if (lt_is_folder(path))
        path = lt_path_join(arena, path, "MANO_RIGHT.pkl");
    if (!path)
        return lt_error(LT_ENOMEM, "no memory for the hand model");
    other = other_side(arena, path);
    st = read_hand(arena, path, &first);
    if (!st && other)
        st = hand_file_read(arena, other, &second);
    if (!st && second && first->left == second->left)
        st = lt_error(LT_EFORMAT, "%s and %s: both are %s hands", path, other, first->left ? "left" : "right");
    if (st)
        return st;
    h->name = path;
    h->left = first->left ? first : second;
    h->right = first->left ? second : first;
    return h->right ? LT_OK : mirrored(arena, h->left, &h->right);
}

bool hands_are_embedded(const hands *h)
{
    return strcmp(h->path, EMBEDDED) == 0;
}

lt_status hands_open(lt_arena *arena, const char *path, hands *out)
{
    hands h = { .name = "embedded synthetic hand" };
    lt_status st;

    if (!path || !*path)
        path = getenv("PALMAR_HAND");
    if (!path || !*path)
        path = EMBEDDED;
    if (strcmp(path, EMBEDDED) == 0) {
        h.path = EMBEDDED;
        st = synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &h.right);
    } else {
        h.path = lt_path_whole(arena, path);
        st = h.path ? open_files(arena, path, &h) : lt_error(LT_ENOMEM, "no memory for the hand model");
    }
    if (st == LT_OK)
        *out = h;
    return st;
}
