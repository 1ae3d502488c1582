/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Errors of many samples gathered into means, shares and areas under curves.
 *
 * Everything here is fed in sample order by one thread (the errors themselves are computed in
 * parallel), so a result does not depend on the number of threads.
 */
#ifndef EVAL_METRICS_CURVE_H
#define EVAL_METRICS_CURVE_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- a mean that refuses failures -------------------------------------------------------- */

typedef struct {
    double sum;
    int64_t n, failed;              /* errors given; how many of them were not finite */
} eval_mean_of;

void eval_mean_add(eval_mean_of *m, double error);

/* eval_mean_value - the mean; NaN when nothing was added or any error was not finite */
double eval_mean_value(const eval_mean_of *m);

/* ---- a share of hits --------------------------------------------------------------------- */

typedef struct { int64_t hits, n; } eval_share;

static inline void eval_share_add(eval_share *s, bool hit) { s->hits += hit; s->n++; }

/* eval_share_value - hits / n; NaN for an empty class, to be left out of class means */
double eval_share_value(const eval_share *s);

/* eval_class_mean - unweighted mean of the values that are not NaN; NaN when all are */
double eval_class_mean(int n_classes, const double *value);

/* ---- PCK and its area -------------------------------------------------------------------- */

/* Share of distances <= t for n_thresholds values of t from lo to hi, both ends included. */
typedef struct eval_pck eval_pck;

/* eval_pck_new - for samples of n_points distances each; NULL when there is no memory. HO3D,
 * FreiHAND, DexYCB hands: 0 to 0.05 m, 100 thresholds. Needs n_thresholds >= 2 and lo < hi. */
eval_pck *eval_pck_new(int n_points, double lo, double hi, int n_thresholds);
void eval_pck_free(eval_pck *pck);

/* eval_pck_add - one sample; a distance that is not finite is beyond every threshold, and a
 * failure */
void eval_pck_add(eval_pck *pck, const double *distance);

/* eval_pck_mean - mean over samples per point, then over points; NaN when empty or with
 * failures */
double eval_pck_mean(const eval_pck *pck);

/* eval_pck_auc - trapezoid under the curve over hi - lo, per point, then the mean over points */
double eval_pck_auc(const eval_pck *pck);

/* eval_pck_threshold, eval_pck_at - the i-th threshold, and the share there, averaged over
 * points */
double eval_pck_threshold(const eval_pck *pck, int i);
double eval_pck_at(const eval_pck *pck, int i);

/* eval_pck_failed - samples that had a distance that is not finite */
int64_t eval_pck_failed(const eval_pck *pck);

/* eval_median_of_points - median over samples per point, then the mean over points; d is
 * (n_samples, n_points). NaN when empty. LT_ENOMEM when there is no memory for one column. */
lt_status eval_median_of_points(int64_t n_samples, int n_points, const double *d, double *out);

/* ---- area in the manner of the YCB-Video toolbox ----------------------------------------- */

/**
 * eval_auc_ycb - area under accuracy against threshold from 0 to `limit`, 0..1; sorts error[n]
 *
 * Errors beyond the limit, and such that are not finite, are misses. Each step takes the
 * accuracy of its right end, so the figure is above the exact integral (eval_auc_exact); papers
 * report this one. NaN for n = 0. Source: yuxng/YCB_Video_toolbox, monotone envelope of VOCap;
 * limit 0.1 m there.
 */
double eval_auc_ycb(int64_t n, double *error, double limit);
double eval_auc_exact(int64_t n, const double *error, double limit);

#ifdef __cplusplus
}
#endif
#endif
