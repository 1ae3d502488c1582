/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Errors of a predicted object pose against the true one.
 *
 * Model points are (n, 3) rows in metres in the model's own frame; "e" is the estimate, "g" the
 * truth. An estimate that is not finite has infinite errors: a failure, never a crash.
 *
 * Sources: Hinterstoisser et al. 2012 (ADD, ADI); Hodan et al., BOP toolkit (MSSD, MSPD);
 * HFL-Net and Semi-Hand-Object utils/metric.py (the reversed ADD-S, REP); HOISDF (OCE, MCE).
 */
#ifndef EVAL_METRICS_OBJECT_POSE_H
#define EVAL_METRICS_OBJECT_POSE_H

#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/pose.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- how large, how symmetric ------------------------------------------------------------ */

typedef enum {
    EVAL_BBOX_DIAG,     /* diagonal of the axis-aligned box: HFL-Net, Semi-Hand-Object, HOCAT */
    EVAL_MAX_DIST,      /* largest distance of two model points: BOP */
} eval_diameter_mode;

const char *eval_diameter_name(eval_diameter_mode mode);        /* "bbox_diag", "max_dist" */
double eval_diameter(eval_diameter_mode mode, int n, const double *x);

typedef enum {
    EVAL_SYM_NONE,      /* ADD for every class: the HO3D tables */
    EVAL_SYM_HFL,       /* bowl, wood block, extra large clamp, foam brick: HFL-Net, HOCAT */
    EVAL_SYM_POSECNN,   /* those and large clamp: PoseCNN, YCB-Video */
    EVAL_SYM_BOP,       /* also the cans and the marker: BOP toolkit, ycbv */
} eval_symmetry_list;

const char *eval_symmetry_name(eval_symmetry_list list);

/* eval_is_symmetric - whether a YCB class (1 .. 21, the ids of YCB-Video and DexYCB) is in the
 * list */
bool eval_is_symmetric(eval_symmetry_list list, int ycb_class);

/* ---- distances of model points, metres --------------------------------------------------- */

/* eval_add - mean distance of the same model point under both poses (ADD; HOISDF calls it MME) */
double eval_add(int n, const double *x, const lt_pose *e, const lt_pose *g);

typedef enum {
    EVAL_FROM_TRUE,         /* over true points, the nearest estimated one: BOP, YCB-Video */
    EVAL_FROM_ESTIMATE,     /* over estimated points, the nearest true one: HFL-Net, HOISDF */
} eval_adds_direction;

/* eval_adds - mean distance to the nearest point (ADD-S). LT_ENOMEM when there is no memory. */
lt_status eval_adds(eval_adds_direction direction, int n, const double *x,
                    const lt_pose *e, const lt_pose *g, double *out);

/* eval_mssd, eval_mspd - largest distance of model points, in metres and in pixels, at the best
 * of n_sym symmetries (model to model); the identity is always tried. Source: BOP challenge
 * 2019. */
double eval_mssd(int n, const double *x, const lt_pose *e, const lt_pose *g,
                 int n_sym, const lt_pose *sym);
double eval_mspd(int n, const double *x, const lt_pose *e, const lt_pose *g,
                 int n_sym, const lt_pose *sym, const lt_camera *camera);

/* ---- rotation, translation, image, boxes ------------------------------------------------- */

double eval_rotation_error_deg(const lt_pose *e, const lt_pose *g);

/* eval_reprojection_px - mean pixel distance of the projected points. z_eps is added to the
 * depth that is divided by: 0, or 1e-5 as Semi-Hand-Object and HFL-Net do. REP-5: the share
 * that is <= 5. */
double eval_reprojection_px(int n, const double *x, const lt_pose *e, const lt_pose *g,
                            const lt_camera *camera, double z_eps);

/* eval_oce - distance of the two object centres (HOISDF): |t_e - t_g| */
double eval_oce(const lt_pose *e, const lt_pose *g);

/* eval_mce - mean distance of the 8 corners of the camera-axis-aligned boxes around the posed
 * points (HOISDF); not of the transformed model box */
double eval_mce(int n, const double *x, const lt_pose *e, const lt_pose *g);

#ifdef __cplusplus
}
#endif
#endif
