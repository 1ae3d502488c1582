/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A subject's hand in its canonical place: the hand model in zero pose with the subject's shape, and what brings it
 * into the camera. Pose blend shapes are not used.
 */
#ifndef TASKS_HOGS_RIG_H
#define TASKS_HOGS_RIG_H

#include "libtensor/geometry/hand/model.h"
#include "libtensor/geometry/mesh/kd_tree.h"
#include "models/hogs/hogs.h"

typedef struct {
    const lt_hand_model *model;
    lt_mesh mesh;                           /* with normals */
    double joint[LT_HAND_JOINTS][3];
    int32_t zone[LT_HAND_VERTICES];         /* contact_zones */
    lt_kd_tree vertices;
} hogs_rig;

/* hogs_rig_new - in the arena; hogs_rig_free frees the rest of it, also after a failure. tips: vertices, as
 * lt_hand_keypoints has them. LT_ENOMEM. */
lt_status hogs_rig_new(lt_arena *arena, const lt_hand_model *hand, const int tips[5], const float *beta,
                       hogs_rig *out);
void hogs_rig_free(hogs_rig *r);

/* hogs_rig_set - the set that it is: its mesh, and a box with a tenth of the extents around it */
hogs_set hogs_rig_set(const hogs_rig *r, int id, const float *beta);

/* A bone's transform (3, 4) from the canonical hand to the camera */
typedef double hogs_bone[12];

/* hogs_rig_bones - rotation (16, 9) as a dataset_sample has it, the wrist at root, metres */
void hogs_rig_bones(const hogs_rig *r, const float *rotation, const float root[3], hogs_bone out[LT_HAND_JOINTS]);

/* hogs_rig_blend - the bones' mean by a vertex's weights */
void hogs_rig_blend(const hogs_rig *r, const hogs_bone bone[LT_HAND_JOINTS], int vertex, hogs_bone out);

/* hogs_rig_samples - n places on the surface (n, 3) and the weights there (n, 16), uniform over its area. LT_ENOMEM */
lt_status hogs_rig_samples(const hogs_rig *r, lt_rng *rng, int n, float (*place)[3],
                           float (*weight)[SKIN_FIELD_BONES]);

static inline void hogs_bone_apply(const hogs_bone T, const double x[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = T[4 * k] * x[0] + T[4 * k + 1] * x[1] + T[4 * k + 2] * x[2] + T[4 * k + 3];
}

#endif
