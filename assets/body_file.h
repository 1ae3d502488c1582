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

enum { BODY_VERTICES = 10475, BODY_FACES = 20908, BODY_JOINTS = 55, BODY_FEATURES = 486,
       BODY_HAND_PCA = 45 };

/* Metres, y up. Rows of a vertex's three coordinates run over directions, as in the file. */
typedef struct {
    int shapes, expressions;        /* directions: 300 and 100, or 10 and 10 in older files */
    float (*v_template)[3];         /* BODY_VERTICES */
    float *shapedirs;               /* (BODY_VERTICES, 3, shapes + expressions) */
    float *posedirs;                /* (BODY_VERTICES, 3, BODY_FEATURES) */
    float *J_regressor;             /* (BODY_JOINTS, BODY_VERTICES) */
    float *weights;                 /* (BODY_VERTICES, BODY_JOINTS) */
    int32_t (*faces)[3];            /* BODY_FACES */
    int parent[BODY_JOINTS];        /* -1 for the pelvis; always before its children */
    bool synthetic;                 /* not SMPL-X: the stand-in that synth_body_new makes */
    float (*hand_components[2])[BODY_HAND_PCA], *hand_mean[2];       /* left, right */
} body_model;

/**
 * body_file_read - a body model
 *
 *   out      owned by the arena; touched only on success
 *
 * synthetic is set by asset_kind = "synthetic". Pickled members of the .npz (joint2num, part2num) are passed over.
 * Errors: LT_EFORMAT names the file, the key, and the shape found against the one wanted; also an index out
 * of range, a number that is not finite, weights whose rows do not sum to 1, a joint before its parent.
 */
lt_status body_file_read(lt_arena *arena, const char *path, body_model **out);

/* body_file_take - the same from arrays that are open already */
struct keyed;
lt_status body_file_take(lt_arena *arena, const struct keyed *k, body_model **out);

/* body_file_write - the .npz form of it, atomically and packed; reads back to the same bits */
lt_status body_file_write(const char *path, const body_model *model);

#ifdef __cplusplus
}
#endif
#endif
