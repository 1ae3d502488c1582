/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The hand layer: a hand model as a rig that lt_skin poses, from 16 rotations and 10 shape numbers to a mesh and its 21
 * keypoints; and the same in double, absolute, for loaders and scores.
 *
 * Rotations are row-major 3 x 3 in MANO's joint order, the wrist's global rotation first; the zero
 * pose is a flat hand (no mean pose is added). Metres.
 *
 * Source: Romero, Tzionas, Black 2017, "Embodied Hands"; Loper et al. 2015, "SMPL".
 */
#ifndef LT_GEOMETRY_HAND_LAYER_H
#define LT_GEOMETRY_HAND_LAYER_H

#include "libtensor/geometry/hand/model.h"
#include "libtensor/geometry/skin/skin.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { LT_HAND_MANO_ORDER, LT_HAND_SIMPLE_ORDER } lt_hand_order;

/* lt_hand_rig - the model's arrays, borrowed from it */
LT_API lt_rig lt_hand_rig(const lt_hand_model *model);

/**
 * lt_hand_pose - pose a hand model
 *
 *   R           (16, 3, 3)
 *   beta        (10)
 *   trans       (3) added to everything at the end, or NULL
 *   vertices    (778, 3), or NULL when only joints are wanted: much cheaper then
 *   joints      (16, 3) MANO order, or NULL
 */
LT_API void lt_hand_pose(const lt_hand_model *model, const double *R, const double *beta,
                         const double *trans, double *vertices, double *joints);

/* lt_hand_rest_wrist - where the wrist is before posing: J0 of lt_flip_yz_mano */
LT_API void lt_hand_rest_wrist(const lt_hand_model *model, const double *beta, double J0[3]);

/**
 * lt_hand_keypoints - the 21 keypoints of a posed hand
 *
 *   vertices (778, 3), joints (16, 3)    of lt_hand_pose
 *   tips       five vertices: thumb, index, middle, ring, little, e.g. lt_hand_tips_ho3d
 *   keypoints  (21, 3)
 */
LT_API void lt_hand_keypoints(const double *vertices, const double *joints, const int tips[5],
                              lt_hand_order order, double *keypoints);

/* A hand's lt_skin: betas are its shape, and its points the 21 keypoints in simple order, of which the wrist comes
 * first */
typedef lt_skin_layer lt_hand_layer;

/* lt_hand_layer_new - lays out `model` (copied) in the arena; tips as in lt_hand_keypoints.
 * LT_ENOMEM; LT_EINVAL when a tip is no vertex, and as lt_kernels_init. */
LT_API lt_status lt_hand_layer_new(lt_arena *arena, const lt_hand_model *model, const int tips[5],
                                   lt_hand_layer **out);

/* lt_hand_layer_tips - the tips that it was made with */
LT_API void lt_hand_layer_tips(const lt_hand_layer *layer, int tips[5]);

#ifdef __cplusplus
}
#endif
#endif
