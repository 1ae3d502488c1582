/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Scoring HO3D's prediction files at home: pred.json or pred.zip against the ground truth that the authors released.
 */
#ifndef EVAL_SCORERS_HO3D_FILES_H
#define EVAL_SCORERS_HO3D_FILES_H

#include "eval/scorers/ho3d/score.h"
#include "eval/scorers/notes.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * ho3d_score_files - the official scores of a prediction file
 *
 *   pred         pred.json, or an archive with it; joints alone, or meshes of other points, are scored as
 *                ho3d_scorer_add_mesh has it
 *   xyz, verts   evaluation_xyz.json, evaluation_verts.json
 *   scores       filled; *n: samples
 *   notes        what is odd about the file, and the slip that it looks like: may be NULL
 *   progress     told how many vertices' frames were scored; false: stop. May be NULL.
 *
 * All three are streams: memory grows by 500 bytes a frame. Errors: those of reading, with file, frame and joint or
 * vertex (a number that is not finite among them); files of different lengths; LT_ESTOPPED.
 */
lt_status ho3d_score_files(const char *pred, const char *xyz, const char *verts, double scores[HO3D_SCORES], int64_t *n,
                           eval_notes *notes, bool (*progress)(void *ctx, int64_t done, int64_t total), void *ctx);

#ifdef __cplusplus
}
#endif
#endif
