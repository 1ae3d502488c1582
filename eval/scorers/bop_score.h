/* SPDX-License-Identifier: Apache-2.0 */
/*
 * BOP's score of a file of object poses: average recalls by VSD, MSSD and MSPD, and their mean.
 *
 * Source: Hodan et al., BOP challenge 2019, as NVlabs/dex-ycb-toolkit's bop_eval.py calls it: VSD with delta 15 mm
 * and tau 0.05 .. 0.5 of the diameter, correct below 0.05 .. 0.5; MSSD below 0.05 .. 0.5 of the diameter; MSPD below
 * 5 .. 50 pixels of an image 640 wide.
 */
#ifndef EVAL_SCORERS_BOP_SCORE_H
#define EVAL_SCORERS_BOP_SCORE_H

#include "data/dexycb/dexycb.h"
#include "eval/scorers/notes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Shares of the targets; NaN without any. */
typedef struct {
    int64_t targets, estimated;     /* annotated objects of key frames; those of them that the file has */
    double vsd, mssd, mspd;
    double ar;                      /* their mean */
} bop_recall;

/* Of all that is on the table, and of what is in the hand: the toolkit's "all" and "grasp only" */
typedef struct { bop_recall all, grasped; } bop_recalls;

/* Called now and then; false stops. */
typedef bool (*bop_progress)(void *ctx, int64_t done, int64_t total);

/**
 * bop_score - the recalls of a csv as dexycb_results_open writes it: metres, the model's own frame
 *
 *   d            a split, with the filter every; its models and depth images are read
 *   models_info  BOP's file of the models' diameters and symmetries, or NULL: the diameter is the largest distance
 *                of two vertices, symmetries are those of ycb_symmetries
 *   notes        estimates that are no poses or for nothing that is scored, by their lines, and the slip that the file
 *                looks like; may be NULL
 *   progress     may be NULL
 *
 * Every annotated object is a target, however little of it is seen. Of several estimates of a target the one with the
 * best score counts; one that is not a rigid pose never hits. The same on any number of threads.
 *
 * Errors: those of bop_file_read, a frame that cannot be read, models_info_read's
 * and a target that models_info lacks, LT_ESTOPPED.
 */
lt_status bop_score(const dataset *d, const char *path, const char *models_info, eval_notes *notes,
                    bop_progress progress, void *ctx, bop_recalls *out);

#ifdef __cplusplus
}
#endif
#endif
