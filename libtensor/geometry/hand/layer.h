/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The hand layer: from 16 rotations and 10 shape numbers to a posed hand mesh and its 21 keypoints.
 *
 * Twice: lt_hand_pose is the plain formula in double, absolute, for loaders and scores; lt_hand_layer is
 * the one that networks learn through, in lt_real with unit-stride arrays, wrist-relative, with gradient.
 *
 * Rotations are row-major 3 x 3 in MANO's joint order, the wrist's global rotation first; the zero
 * pose is a flat hand (no mean pose is added). Metres.
 *
 * Source: Romero, Tzionas, Black 2017, "Embodied Hands"; Loper et al. 2015, "SMPL".
 */
#ifndef LT_GEOMETRY_HAND_LAYER_H
#define LT_GEOMETRY_HAND_LAYER_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/hand/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { LT_HAND_MANO_ORDER, LT_HAND_SIMPLE_ORDER } lt_hand_order;

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

/* A hand model laid out for speed. Read-only once made: any number of threads may use it. */
typedef struct lt_hand_layer lt_hand_layer;

/* lt_hand_layer_new - lays out `model` (copied) in the arena; tips as in lt_hand_keypoints.
 * LT_ENOMEM; LT_EINVAL when a tip is no vertex, and as lt_kernels_init. */
LT_API lt_status lt_hand_layer_new(lt_arena *arena, const lt_hand_model *model, const int tips[5],
                                   lt_hand_layer **out);

enum {
    LT_HAND_GROUP = 16,                         /* vertices beside each other, */
    LT_HAND_GROUPS = 49,                        /* and how many such groups have them all */
    LT_HAND_PADDED = LT_HAND_GROUPS * LT_HAND_GROUP,
    LT_HAND_BLENDS = 1 + LT_HAND_BETAS + LT_HAND_POSE_FEATURES,     /* the template, shape and pose directions */
};

/* Coordinates of vertices: those of vertex i are group[i / LT_HAND_GROUP][0 to 2][i % LT_HAND_GROUP]. */
typedef struct { lt_real group[LT_HAND_GROUPS][3][LT_HAND_GROUP]; } lt_hand_vertices;

/* The arrays of a layer, for those who write it down elsewhere. */
typedef struct {
    const lt_hand_vertices *blend;              /* (146) template, shape directions, pose directions */
    const lt_real (*weight)[LT_HAND_PADDED];    /* (16, V) */
    const double (*rest)[3];                    /* (16, 3) joints of the mean shape, */
    const double (*rest_beta)[LT_HAND_JOINTS][3];           /* (10, 16, 3) and how they follow beta */
    const int *tips;                            /* (5) */
} lt_hand_tables;

/* lt_hand_layer_tables - borrowed from the layer; only the first 778 vertices count */
LT_API lt_hand_tables lt_hand_layer_tables(const lt_hand_layer *layer);

/* What forward leaves for backward, one sample's worth; the caller's memory. */
typedef struct {
    lt_hand_vertices posed;                     /* with shape and pose offsets, before skinning */
    lt_real skin[12][LT_HAND_PADDED];           /* backward's: each vertex's blended rotation (3, 3), and a gradient */
    lt_real coef[LT_HAND_BLENDS];               /* of the blends: 1, of shape and of pose offsets */
    lt_real frame[LT_HAND_JOINTS][12];          /* each joint's rotation (3, 3), and where the origin goes (3) */
    double rest[LT_HAND_JOINTS][3];             /* joints before posing */
    double world_R[LT_HAND_JOINTS][9];          /* of each joint's frame */
    double world_t[LT_HAND_JOINTS][3];
} lt_hand_scratch;

/**
 * lt_hand_layer_forward - n samples, on all threads
 *
 *   R          (n, 16, 3, 3); any matrices, the formula does not ask for rotations
 *   beta       (n, 10)
 *   vertices   (n, 778, 3) relative to the wrist
 *   keypoints  (n, 21, 3) in simple order, relative to the wrist; the first is zero
 *   scratch    (n)
 *
 * On a CPU with AMX's tiles 16 and more samples together may have other last bits than each alone.
 */
LT_API void lt_hand_layer_forward(const lt_hand_layer *layer, int64_t n, const lt_real *R, const lt_real *beta,
                                  lt_real *vertices, lt_real *keypoints, lt_hand_scratch *scratch);

/**
 * lt_hand_layer_backward - gradients of n samples, on all threads
 *
 *   R, scratch                 as forward took and left them; scratch is used up
 *   d_vertices (n, 778, 3)     or NULL for zero
 *   d_keypoints (n, 21, 3)     or NULL for zero
 *   d_R (n, 16, 3, 3)          added to, or NULL
 *   d_beta (n, 10)             added to, or NULL
 */
LT_API void lt_hand_layer_backward(const lt_hand_layer *layer, int64_t n, const lt_real *R,
                                   const lt_real *d_vertices, const lt_real *d_keypoints,
                                   lt_real *d_R, lt_real *d_beta, lt_hand_scratch *scratch);

#ifdef __cplusplus
}
#endif
#endif
