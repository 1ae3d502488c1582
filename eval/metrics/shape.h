/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How like two surfaces are: Chamfer distance and F-scores, after an alignment or as they are.
 *
 * Sources: zerchen/gSDF datasets/dexycb/dexycb.py (30,000 samples, squared distances, cm^2); zc-alexfan/hold
 * code/src/utils/icp.py, eval_modules.py (alignment, CD with pose); zerchen/AlignSDF (without rotation).
 */
#ifndef EVAL_METRICS_SHAPE_H
#define EVAL_METRICS_SHAPE_H

#include "libtensor/base/status.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { EVAL_SURFACE_SAMPLES = 30000, EVAL_ALIGNING_SAMPLES = 1000, EVAL_POSE_VERTICES = 3000 };

typedef enum {
    EVAL_AS_IT_IS,
    EVAL_BY_SIMILARITY,             /* rotation, translation, scale: lt_icp_best_similarity, pairs within 10 mm */
    EVAL_WITHOUT_ROTATION,          /* translation and scale: lt_icp_scale_translation */
} eval_shape_alignment;

/* Mean squared distances both ways added, cm^2; F-scores within 1, 5, 10 mm, 0 .. 1 */
typedef struct { double cd_cm2, f_1mm, f_5mm, f_10mm; } eval_shape_score;

/**
 * eval_shape - of a predicted surface p and the true one g, of as many samples each, by area
 *
 * Samples are drawn by a seed that is the same for both, and the same every time. Errors: LT_EINVAL for a mesh without
 * area or with numbers that are not finite; LT_ENOMEM.
 */
lt_status eval_shape(eval_shape_alignment how, const lt_mesh *p, const lt_mesh *g, eval_shape_score *out);

/* eval_shape_of_vertices - the same of all vertices, after a similarity. Errors: those of eval_shape
 * eval_shape_of_points - the scores of two point sets as they are. LT_ENOMEM */
lt_status eval_shape_of_vertices(const lt_mesh *p, const lt_mesh *g, eval_shape_score *out);
lt_status eval_shape_of_points(int np, const double (*p)[3], int ng, const double (*g)[3], eval_shape_score *out);

/* eval_pose_chamfer_cm2 - of 3,000 vertices of each, drawn with replacement, each seen from its wrist. LT_ENOMEM */
lt_status eval_pose_chamfer_cm2(const lt_mesh *p, const float wrist_p[3], const lt_mesh *g, const float wrist_g[3],
                                double *out);

#ifdef __cplusplus
}
#endif
#endif
