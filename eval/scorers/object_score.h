/* SPDX-License-Identifier: Apache-2.0 */
/*
 * All object errors of many samples, computed on all threads.
 */
#ifndef EVAL_SCORERS_OBJECT_SCORE_H
#define EVAL_SCORERS_OBJECT_SCORE_H

#include "eval/metrics/object_pose.h"

#ifdef __cplusplus
extern "C" {
#endif

/* An object as it is scored: points.xyz, (n, 3) metres, borrowed. */
typedef struct {
    int n_points;
    const double *point;
    bool symmetric;                 /* eval_is_symmetric of the list in use */
} eval_object;

/* One sample's. Metres, degrees, pixels; infinite where the estimate is not finite. */
typedef struct {
    double add;
    double adds_true, adds_estimate;        /* ADD-S in both directions, see eval_adds_direction */
    double add_or_adds;             /* add, or adds_estimate if symmetric: ADD-0.1D on DexYCB [HFL-Net] */
    double rotation_deg;
    double reprojection_px;         /* depth plus 1e-5, as Semi-Hand-Object and HFL-Net; REP-5: <= 5 */
    double oce, mce;
} eval_object_errors;

/**
 * eval_object_measure - the errors of n samples
 *
 *   objects          the models; which (n) says whose a sample is, -1 for a sample without object
 *   e, g             (n) estimated and true poses
 *   camera           (n)
 *   out              (n) the caller's; all NaN where there is no object
 *
 * The result does not depend on the number of threads. Errors: LT_ENOMEM.
 */
lt_status eval_object_measure(const eval_object *objects, int64_t n, const int32_t *which,
                              const lt_pose *e, const lt_pose *g, const lt_camera *camera,
                              eval_object_errors *out);

#ifdef __cplusplus
}
#endif
#endif
