/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Hand models on disk: MANO's own .pkl as it is downloaded, and the same arrays in a .npz.
 */
#ifndef ASSETS_HAND_FILE_H
#define ASSETS_HAND_FILE_H

#include "libtensor/base/arena.h"
#include "libtensor/base/status.h"
#include "libtensor/geometry/hand/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * hand_file_read - a MANO-shaped hand model from a .pkl or a .npz
 *
 *   out      owned by the arena; touched only on success
 *
 * The first bytes tell the format, not the name: see keyed_open. Keys: v_template, shapedirs, posedirs, weights,
 * J_regressor, f, hands_components, hands_mean; kintree_table is checked where it is there. Arrays may
 * be of any number type; as objects of Python's they may be chumpy's, sparse matrices, numpy.matrix or lists. shapedirs
 * may have more than 10 directions: the first 10 are kept. left is set when the fingers point to +x.
 * synthetic is set by asset_kind = "synthetic".
 *
 * Errors: LT_EFORMAT names the file, the key, and the shape found against the one wanted; also a face
 * index out of range, a number that is NaN or infinite, weights whose rows do not sum to 1, a hand of a size that none
 * has (which unit would make it one is said) or that does not lie along x, and anything that keyed_open refuses.
 * LT_EIO, LT_ENOMEM.
 */
lt_status hand_file_read(lt_arena *arena, const char *path, lt_hand_model **out);

/* hand_file_take - the same from arrays that are open already */
struct keyed;
lt_status hand_file_take(lt_arena *arena, const struct keyed *k, lt_hand_model **out);

/* What to make of a left hand's shape directions. Labels were made with each of the three. */
typedef enum {
    HAND_LEFT_AS_IS,                /* as released: DexYCB */
    HAND_LEFT_FIX_X,                /* x turned: InterHand, ARCTIC, Keypoint Transformer */
    HAND_LEFT_NEGATE_ALL,           /* all of them turned: H2O-3D */
} hand_left_fix;

/* hand_left_is_flipped - the released MANO_LEFT.pkl has its shape directions' x as in the right hand, where
 * a mirror image has the opposite; a right hand tells. True when their x differ by less than 1 in all. */
bool hand_left_is_flipped(const lt_hand_model *left, const lt_hand_model *right);

/* hand_left_shape - turn the directions that how says */
void hand_left_shape(lt_hand_model *left, hand_left_fix how);

/* hand_file_write - the .npz form of it, atomically and packed; reads back to the same bits */
lt_status hand_file_write(const char *path, const lt_hand_model *model);

#ifdef __cplusplus
}
#endif
#endif
