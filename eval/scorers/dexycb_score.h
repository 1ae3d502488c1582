/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The DexYCB hand score and its result file.
 *
 * Joints are (n, 21, 3) in simple order, in metres, absolute, in OpenCV camera axes.
 *
 * Source: NVlabs/dex-ycb-toolkit hpe_eval.py (HPE: absolute, root-relative, Procrustes with
 * reflections); HFL-Net utils/metric.py for the rigid Procrustes that the papers' PAMPJPE on
 * DexYCB comes from.
 */
#ifndef EVAL_SCORERS_DEXYCB_SCORE_H
#define EVAL_SCORERS_DEXYCB_SCORE_H

#include "libtensor/base/common.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Means are in mm, areas (0 to 50 mm, 100 thresholds) in 0..1. */
typedef enum {
    DEXYCB_MEAN, DEXYCB_AUC,                        /* as they are */
    DEXYCB_RELATIVE_MEAN, DEXYCB_RELATIVE_AUC,      /* wrist on wrist: the papers' MPJPE */
    DEXYCB_PA_MEAN, DEXYCB_PA_AUC,                  /* Procrustes with reflections: the toolkit's */
    DEXYCB_RIGID_MEAN, DEXYCB_RIGID_AUC,            /* Procrustes without: the papers' PAMPJPE */
    DEXYCB_SCORES
} dexycb_score;

const char *dexycb_score_name(dexycb_score score);

/* One sample's means, metres; infinite for a failure. */
typedef struct { double absolute, relative, pa, rigid; } dexycb_sample_errors;

typedef struct dexycb_scorer dexycb_scorer;

dexycb_scorer *dexycb_scorer_new(void);             /* NULL when there is no memory */
void dexycb_scorer_free(dexycb_scorer *s);

/* dexycb_scorer_add - n more samples in the order of the list; p, g (n, 21, 3); each (n) or
 * NULL. A sample that is not finite is a failure, as in ho3d_scorer_add. Runs on all threads,
 * same bits on any number. */
void dexycb_scorer_add(dexycb_scorer *s, int64_t n, const float *p, const float *g,
                       dexycb_sample_errors *each);

/* dexycb_scorer_scores - so far; all NaN without samples */
void dexycb_scorer_scores(const dexycb_scorer *s, double scores[DEXYCB_SCORES]);

/* ---- the toolkit's result file: a line "index,x0,y0,z0,...,z20" per sample, mm ----------- */

/* dexycb_hpe_line - the line of sample `index` (its place in the official list), joints in
 * metres */
void dexycb_hpe_line(FILE *f, int64_t index, const float *joints);

#ifdef __cplusplus
}
#endif
#endif
