/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The arrays of a MANO-shaped hand model, and the joint orders of the datasets that use it.
 *
 * Source: Romero, Tzionas, Black 2017, "Embodied Hands". The licensed model is the user's own file; the
 * embedded default (data/synth/hand) has the same array shapes.
 */
#ifndef LT_GEOMETRY_HAND_MODEL_H
#define LT_GEOMETRY_HAND_MODEL_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    LT_HAND_VERTICES = 778,
    LT_HAND_FACES = 1538,
    LT_HAND_JOINTS = 16,            /* wrist; index, middle, little, ring, thumb, three each */
    LT_HAND_KEYPOINTS = 21,         /* the joints, then five finger tips */
    LT_HAND_BETAS = 10,
    LT_HAND_POSE_FEATURES = 135,    /* 15 rotations, 9 numbers each */
    LT_HAND_PCA = 45,
};

/* Rest pose is a flat right hand: fingers to -x, back of the hand +y, thumb side +z; metres. */
typedef struct {
    float v_template[LT_HAND_VERTICES][3];
    float shapedirs[LT_HAND_VERTICES][3][LT_HAND_BETAS];
    float posedirs[LT_HAND_VERTICES][3][LT_HAND_POSE_FEATURES];
    float J_regressor[LT_HAND_JOINTS][LT_HAND_VERTICES];
    float weights[LT_HAND_VERTICES][LT_HAND_JOINTS];
    int32_t faces[LT_HAND_FACES][3];
    float hands_mean[LT_HAND_PCA];
    float hands_components[LT_HAND_PCA][LT_HAND_PCA];   /* rows are principal directions */
    bool left;                      /* mirrored in x */
    bool synthetic;                 /* not MANO: the embedded stand-in */
} lt_hand_model;

/* Parent of each joint; -1 for the wrist. */
static const int lt_hand_parent[LT_HAND_JOINTS] = {
    -1, 0, 1, 2, 0, 4, 5, 0, 7, 8, 0, 10, 11, 0, 13, 14,
};

/* Vertices of the finger tips, in the order thumb, index, middle, ring, little. */
static const int lt_hand_tips_ho3d[5] = { 728, 353, 442, 576, 694 };
static const int lt_hand_tips_dexycb[5] = { 745, 317, 444, 556, 673 };

/* keypoint_simple[i] = keypoint_mano[lt_mano_to_simple[i]], and back. "Simple": wrist, then thumb,
 * index, middle, ring, little, four each from base to tip. "MANO": the 16 joints, then the tips. */
static const int lt_mano_to_simple[LT_HAND_KEYPOINTS] = {
    0, 13, 14, 15, 16, 1, 2, 3, 17, 4, 5, 6, 18, 10, 11, 12, 19, 7, 8, 9, 20,
};
static const int lt_simple_to_mano[LT_HAND_KEYPOINTS] = {
    0, 5, 6, 7, 9, 10, 11, 17, 18, 19, 13, 14, 15, 1, 2, 3, 4, 8, 12, 16, 20,
};

#ifdef __cplusplus
}
#endif
#endif
