/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The official HO3D hand score: what the challenge server computes, to the line.
 *
 * Joints are (n, 21, 3) in MANO order, vertices (n, 778, 3), both in metres, absolute, in
 * OpenGL camera axes (x right, y up, z backward), as in a submission. ho3d_joints_from_camera
 * and ho3d_vertices_from_camera make them of our own.
 *
 * Source: shreyashampali/ho3d eval.py and README (11,524 evaluation samples in version 2,
 * 20,137 in 3).
 */
#ifndef EVAL_SCORERS_HO3D_SCORE_H
#define EVAL_SCORERS_HO3D_SCORE_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"
#include "libtensor/geometry/hand/model.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The lines of scores.txt in their order. Means are in cm, the rest in 0..1. */
typedef enum {
    HO3D_XYZ_MEAN, HO3D_XYZ_AUC,                    /* joints as they are */
    HO3D_XYZ_PA_MEAN, HO3D_XYZ_PA_AUC,              /* after Procrustes: 10 * mean is PAMPJPE in mm */
    HO3D_XYZ_ST_MEAN, HO3D_XYZ_ST_AUC,              /* after scale and translation */
    HO3D_MESH_MEAN, HO3D_MESH_AUC,
    HO3D_MESH_PA_MEAN, HO3D_MESH_PA_AUC,            /* 10 * mean is PAMPVPE in mm */
    HO3D_F_5, HO3D_F_AL_5,                          /* 5 mm: vertices plain, after Procrustes */
    HO3D_F_15, HO3D_F_AL_15,
    HO3D_SCORES
} ho3d_score;

/* The same errors for one sample, for lists of the best and worst; metres, and 0..1 for F. */
typedef struct {
    double xyz, xyz_pa, xyz_st, mesh, mesh_pa;
    double f5, f_al5, f15, f_al15;
} ho3d_sample_errors;

/* Sums over samples. The memory does not grow with their number. */
typedef struct ho3d_scorer ho3d_scorer;

ho3d_scorer *ho3d_scorer_new(void);             /* NULL when there is no memory */
void ho3d_scorer_free(ho3d_scorer *s);

/**
 * ho3d_scorer_add - n more samples, in the order of the evaluation list
 *
 *   p_xyz, p_verts   predicted; a sample with a number that is not finite is a failure: F of 0,
 *                    never a correct keypoint, and the means become NaN
 *   g_xyz, g_verts   true
 *   each             (n) the samples' own errors, or NULL; infinite for failures
 *
 * Runs on all threads; the scores have the same bits whatever their number and however the
 * samples are split into calls. Errors: LT_ENOMEM.
 */
lt_status ho3d_scorer_add(ho3d_scorer *s, int64_t n, const float *p_xyz, const float *p_verts,
                          const float *g_xyz, const float *g_verts, ho3d_sample_errors *each);

/**
 * ho3d_scorer_add_mesh - the same of meshes with another number of points than MANO's
 *
 *   points           of p_verts (n, points, 3), of all samples of a scorer; 778 is ho3d_scorer_add, 0: joints alone
 *
 * As the script has it, the four mesh scores then are -1 (the means -100, for it has them in cm), and vertices are
 * aligned for F by what aligns the joints, with a scale that is not divided by the prediction's own.
 */
lt_status ho3d_scorer_add_mesh(ho3d_scorer *s, int64_t n, const float *p_xyz, const float *p_verts, int points,
                               const float *g_xyz, const float *g_verts);

/* ho3d_scorer_scores - the scores so far; all NaN without samples */
void ho3d_scorer_scores(const ho3d_scorer *s, double scores[HO3D_SCORES]);

/* ho3d_scorer_failed - samples so far whose prediction was not finite */
int64_t ho3d_scorer_failed(const ho3d_scorer *s);

/* ho3d_print_scores - the text of scores.txt: 14 lines "name: %f" */
void ho3d_print_scores(FILE *f, const double scores[HO3D_SCORES]);

/* ho3d_write_scores - that text as a file, atomically; errors as lt_atomic_commit */
lt_status ho3d_write_scores(const char *path, const double scores[HO3D_SCORES]);

/* ho3d_joints_from_camera, ho3d_vertices_from_camera - joints (21, 3) and vertices (778, 3) of
 * our own convention (OpenCV axes, simple order) as HO3D has them; out may not be the input */
void ho3d_joints_from_camera(const float *joints, float *out);
void ho3d_vertices_from_camera(const float *vertices, float *out);

#ifdef __cplusplus
}
#endif
#endif
