/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A rig: a mesh that hangs on a tree of joints, as arrays. MANO, SMPL and SMPL-X are rigs, and so are made-up ones.
 * skin.h is the layer that networks learn through; here is the same formula, plainly, in double, for loaders and
 * scores.
 *
 * Rotations are row-major 3 x 3, each joint's in its parent's frame, the root's global rotation first. Metres.
 *
 * Source: Loper et al. 2015, "SMPL", equations 2 to 10; the arrays have the names of its files.
 */
#ifndef LT_GEOMETRY_SKIN_RIG_H
#define LT_GEOMETRY_SKIN_RIG_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LT_RIG_JOINTS = 128 };           /* the most that a rig may have */

/* P = 9 (J - 1): the numbers R_k - I of the joints behind the root, by which pose blends go */
typedef struct {
    int V, J, S;                        /* vertices, joints, shape directions */
    const int *parents;                 /* (J) the root comes first with -1, others after their parents */
    const float *v_template;            /* (V, 3) */
    const float *shapedirs;             /* (V, 3, S) */
    const float *posedirs;              /* (V, 3, P), or NULL for none */
    const float *J_regressor;           /* (J, V) */
    const float *weights;               /* (V, J) */
} lt_rig;

/**
 * lt_rig_pose - pose a rig
 *
 *   R           (J, 3, 3)
 *   shape       (S)
 *   trans       (3) added to everything at the end, or NULL
 *   vertices    (V, 3), or NULL when only joints are wanted: much cheaper then
 *   joints      (J, 3), or NULL
 */
LT_API void lt_rig_pose(const lt_rig *rig, const double *R, const double *shape, const double *trans,
                        double *vertices, double *joints);

/* lt_rig_root - where the root is before posing, and also after it */
LT_API void lt_rig_root(const lt_rig *rig, const double *shape, double root[3]);

/* lt_rig_chain - frames of the J joints: world_R_k = world_R_parent R_k, and
 * world_t_k = world_t_parent + world_R_parent (rest_k - rest_parent); the root stands at `root`. */
void lt_rig_chain(int J, const int *parents, const double (*rest)[3], const double *R, const double root[3],
                  double (*world_R)[9], double (*world_t)[3]);

#ifdef __cplusplus
}
#endif
#endif
