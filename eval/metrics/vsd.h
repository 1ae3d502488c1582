/* SPDX-License-Identifier: Apache-2.0 */
/*
 * BOP's visible surface discrepancy: by how much the visible surface differs between an object drawn at its
 * estimated pose and at its true one, where a depth image tells what is visible.
 *
 * Source: Hodan et al., BOP toolkit, pose_error.vsd with visib_mode "bop19" and cost_type "step".
 */
#ifndef EVAL_METRICS_VSD_H
#define EVAL_METRICS_VSD_H

#include "libtensor/geometry/camera.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What was measured, and when two surfaces agree. Depths are (height, width), metres along the optical axis, 0 for
 * none. */
typedef struct {
    int width, height;
    lt_camera camera;
    const float *measured;
    double delta;                   /* metres behind the measured surface that still count as visible: BOP 0.015 */
    double diameter;                /* of the object; distances are divided by it */
} eval_vsd_view;

/**
 * eval_vsd - errors[k] in 0 .. 1 for misalignment tolerances tau[k], shares of the diameter
 *
 *   e, g     depth of the object alone at the estimated and at the true pose
 *
 * 1 where neither is visible.
 */
void eval_vsd(const eval_vsd_view *view, const float *e, const float *g, int n, const double *tau, double *errors);

#ifdef __cplusplus
}
#endif
#endif
