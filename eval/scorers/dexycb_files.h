/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The result files that DexYCB's toolkit takes: hand joints as text (HPE), object poses as BOP's csv, detections with
 * key points as COCO's JSON. What is estimated for a mirrored sample is mirrored back here.
 *
 * Source: NVlabs/dex-ycb-toolkit hpe_eval.py, bop_eval.py, coco_eval.py.
 */
#ifndef EVAL_SCORERS_DEXYCB_FILES_H
#define EVAL_SCORERS_DEXYCB_FILES_H

#include "data/dexycb/dexycb.h"
#include "eval/scorers/dexycb_score.h"
#include "eval/scorers/notes.h"
#include "libtensor/geometry/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What is said of one sample. */
typedef struct {
    dexycb_place place;
    bool mirrored;
    int width;                      /* of the image */
    lt_camera camera;               /* the sample's: in the mirror where it is mirrored */
    const float (*joints)[3];       /* (21, 3) simple order, metres */
    double seconds;                 /* BOP's time of the image; -1: not measured */
    bool has_object;
    lt_pose object;               /* of the model that the sample shows */
    double score;                   /* of the object, 0 .. 1 */
} dexycb_result;

typedef struct dexycb_results dexycb_results;

/**
 * dexycb_results_open - begin a file; its ending tells which
 *
 *   .txt     "index,x0,y0,z0,...": millimetres, index in the toolkit's list
 *   .csv     scene_id,im_id,obj_id,score,R,t,time: key frames alone, the object in the hand; R by rows, t in
 *            metres and the model's own frame, as the toolkit reads it (it turns both into BOP's millimetres)
 *   .json    a list of {image_id, category_id 22, bbox, score, keypoints}: hands
 *
 * Errors: LT_EINVAL for another ending, those of lt_atomic_open. Ends in dexycb_results_close or _abort.
 */
lt_status dexycb_results_open(const char *path, dexycb_results **out);

void dexycb_results_add(dexycb_results *f, const dexycb_result *r);

/* dexycb_results_close - the whole file under its name; errors of lt_atomic_commit */
lt_status dexycb_results_close(dexycb_results *f);
void dexycb_results_abort(dexycb_results *f);           /* NULL is fine */

/**
 * dexycb_score_hpe - the toolkit's scores of an HPE file
 *
 *   d        the split, with the filter valid: each of its samples has to be in the file; more may be
 *   scores   DEXYCB_SCORES of them
 *   notes    lines for no sample of the split, and the slip that the file looks like; may be NULL
 *
 * Errors: those of hpe_file_read, a sample that is missing, a label that cannot be read.
 */
lt_status dexycb_score_hpe(const dataset *d, const char *path, double scores[DEXYCB_SCORES], eval_notes *notes);

#ifdef __cplusplus
}
#endif
#endif
