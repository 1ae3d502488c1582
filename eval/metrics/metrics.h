/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Errors between one predicted and one true point set: joints or mesh vertices of a sample.
 *
 * Points are (n, 3) rows of x y z in metres, in double, the prediction P first and the ground
 * truth G second. Nothing here allocates but where it says so. A number that is not finite in P
 * makes the distances of its point infinite: a failure, which the accumulators in eval/metrics/curve.h
 * count.
 */
#ifndef EVAL_METRICS_METRICS_H
#define EVAL_METRICS_METRICS_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* eval_widen - the n floats of x as doubles */
void eval_widen(int64_t n, const float *x, double *out);

/* eval_distances - d[i] = |p_i - g_i|; +infinity where that is not a finite number */
void eval_distances(int n, const double *p, const double *g, double *d);

/* eval_mean - the mean of d[n], added in order; NaN for n = 0 */
double eval_mean(int64_t n, const double *d);

/* eval_mpjpe - mean distance without any alignment; infinite when P is not finite */
double eval_mpjpe(int n, const double *p, const double *g);

/* ---- alignment: out may be p ------------------------------------------------------------- */

/* eval_align_root - P moved so that its point `root` lies on that of G */
void eval_align_root(int n, const double *p, const double *g, int root, double *out);

typedef enum {
    EVAL_REFLECT,       /* HO3D, FreiHAND, the DexYCB toolkit: reflections are allowed */
    EVAL_RIGID,         /* HFL-Net, HOISDF (Umeyama): the determinant of R is held at +1 */
} eval_procrustes_kind;

/**
 * eval_align_procrustes - P under the similarity (scale, rotation, translation) that fits G best
 *
 * A prediction that is one point lands on the mean of G. When P is not finite, out is all NaN.
 *
 * Source: shreyashampali/ho3d eval.py, and HFL-Net utils/metric.py; see
 * libtensor/geometry/procrustes.h.
 */
void eval_align_procrustes(eval_procrustes_kind kind, int n, const double *p, const double *g,
                           double *out);

/**
 * eval_align_scale - P scaled to the length of one bone of G, its point `base` put on that of G
 *
 * The bone runs from base to tip: joints 0 and 4 (middle MCP, in MANO's order) for the HO3D
 * score. When P's bone has no length, P is scaled by the length of G's, as the official script
 * does. When P is not finite, out is all NaN.
 */
void eval_align_scale(int n, const double *p, const double *g, int base, int tip, double *out);

/* ---- point sets without correspondence --------------------------------------------------- */

/**
 * eval_nearest - for each point the distance to the nearest one of the other set, both ways
 *
 * d_p[np] and d_g[ng] are infinite when the other set is empty; a point that is not finite is
 * far from all. d_p or d_g may be NULL. Memory: LT_ENOMEM when there is none.
 */
lt_status eval_nearest(int np, const double *p, int ng, const double *g, double *d_p,
                       double *d_g);

typedef struct { double f, precision, recall; } eval_f;

/**
 * eval_f_score - F = 2 P R / (P + R) at a distance, out of the distances of eval_nearest
 *
 * Precision is the share of predicted points strictly closer than `within` to the true set,
 * recall the share of true points that close to the predicted set. 0 when both are 0 or a set
 * is empty.
 */
eval_f eval_f_score(int np, const double *d_p, int ng, const double *d_g, double within);

/* eval_chamfer_cm2 - mean d^2 from G to P plus mean d^2 from P to G, in cm^2 (HOLD, gSDF); NaN
 * if empty */
double eval_chamfer_cm2(int np, const double *d_p, int ng, const double *d_g);

#ifdef __cplusplus
}
#endif
#endif
