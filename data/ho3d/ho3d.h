/* SPDX-License-Identifier: Apache-2.0 */
/*
 * HO3D v2 and v3 as downloaded: train.txt, evaluation.txt, rgb (png or jpg), depth, meta pickles, models/.
 *
 * Source: Hampali et al. 2020, "HOnnotate"; files as shreyashampali/ho3d reads them.
 */
#ifndef DATA_HO3D_HO3D_H
#define DATA_HO3D_HO3D_H

#include "data/dataset.h"

#ifdef __cplusplus
extern "C" {
#endif

extern const dataset_kind ho3d_kind;

typedef struct {
    const char *root;               /* the folder with train.txt */
    const char *split;              /* "train" or "evaluation" */
    const char *models;             /* the folder of the YCB models; NULL: root/models, then beside root */
    bool vertices;                  /* evaluation: read evaluation_verts.json as well (9 kB a frame) */
    bool no_objects;                /* hand only: models are not needed, samples have no object */
} ho3d_options;

/**
 * ho3d_open - the samples of a split, in the order of its text file
 *
 * Evaluation samples have the hand box, the wrist and the object; where root holds evaluation_xyz.json
 * (released by the authors in 2024) they have joints too, and vertices where asked for.
 *
 * Errors: missing folder, list, models or ground truth of another length; H2O-3D; the line says what to do.
 * The caller frees *out with dataset_free.
 */
lt_status ho3d_open(const ho3d_options *options, dataset **out);

/* ho3d_read_truth - evaluation_xyz.json or evaluation_verts.json: n frames of (points, 3), OpenGL axes
 * and MANO order as in the file, streamed; out belongs to arena.
 * Errors: not that shape; the line names the frame and point. */
lt_status ho3d_read_truth(lt_arena *arena, const char *path, int64_t n, int points, float **out);

#ifdef __cplusplus
}
#endif
#endif
