/* SPDX-License-Identifier: Apache-2.0 */
/*
 * SMPL-X on disk: SMPLX_NEUTRAL.npz, SMPLX_MALE.npz and SMPLX_FEMALE.npz as they are downloaded, or the same
 * arrays in a .pkl.
 */
#ifndef ASSETS_BODY_FILE_H
#define ASSETS_BODY_FILE_H

#include "libtensor/base/arena.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LT_BODY_VERTICES = 10475, LT_BODY_FACES = 20908, LT_BODY_JOINTS = 55, LT_BODY_FEATURES = 486,
       LT_BODY_HAND_PCA = 45 };

/* Metres, y up. Rows of a vertex's three coordinates run over directions, as in the file. */
typedef struct {
    int shapes, expressions;        /* directions: 300 and 100, or 10 and 10 in older files */
    float (*v_template)[3];         /* LT_BODY_VERTICES */
    float *shapedirs;               /* (LT_BODY_VERTICES, 3, shapes + expressions) */
    float *posedirs;                /* (LT_BODY_VERTICES, 3, LT_BODY_FEATURES) */
    float *J_regressor;             /* (LT_BODY_JOINTS, LT_BODY_VERTICES) */
    float *weights;                 /* (LT_BODY_VERTICES, LT_BODY_JOINTS) */
    int32_t (*faces)[3];            /* LT_BODY_FACES */
    int parent[LT_BODY_JOINTS];     /* -1 for the pelvis; always before its children */
    float (*hand_components[2])[LT_BODY_HAND_PCA], *hand_mean[2];       /* left, right */
} lt_body_model;

/**
 * lt_body_model_read - a body model
 *
 *   out      owned by the arena; touched only on success
 *
 * Pickled members of the .npz (joint2num, part2num) are passed over.
 * Errors: LT_EFORMAT names the file, the key, and the shape found against the one wanted; also an index out
 * of range, a number that is not finite, weights whose rows do not sum to 1, a joint before its parent.
 */
LT_API lt_status lt_body_model_read(lt_arena *arena, const char *path, lt_body_model **out);

#ifdef __cplusplus
}
#endif
#endif
