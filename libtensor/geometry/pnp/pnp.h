/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pose of an object of known shape from where its points are seen: EPnP, RANSAC, refinement.
 *
 * x_cam = R x_obj + t. Object points X are (n, 3) metres, image points uv (n, 2) pixels, row by row. A point
 * may be given many times with several places, as networks that vote do. Statuses:
 *
 *   LT_EINVAL     the call cannot be: too few points, a number that is not finite, focal length 0
 *   LT_ENUMERIC   no pose explains the points: all equal, on a line, too few inliers
 *   LT_ENOMEM     lt_pnp_ransac of more than 256 inliers; all else allocates nothing
 *
 * and outputs are then untouched.
 */
#ifndef LT_GEOMETRY_PNP_PNP_H
#define LT_GEOMETRY_PNP_PNP_H

#include "libtensor/geometry/camera.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * lt_epnp - pose of n >= 4 points, all trusted
 *
 * Points are weighted sums of four control points, whose camera coordinates are found among the four
 * smallest eigenvectors of a 12 x 12 matrix; three first guesses, each with five Gauss-Newton steps;
 * the one with the least mean reprojection error is kept. Points in one plane, which leave the fourth
 * control point without meaning, go to lt_pnp_planar.
 *
 * Source: Lepetit, Moreno-Noguer, Fua 2009, "EPnP: an accurate O(n) solution to the PnP problem".
 */
LT_API lt_status lt_epnp(const lt_camera *cam, int n, const double *X, const double *uv,
                         double R[9], double t[3]);

/* lt_pnp_planar - pose of n >= 4 points that lie in a plane or nearly so, from the plane's homography */
LT_API lt_status lt_pnp_planar(const lt_camera *cam, int n, const double *X, const double *uv,
                               double R[9], double t[3]);

/* lt_pnp_refine - Levenberg-Marquardt on the reprojection error over (rotation vector, t), in place. Never
 * makes the error larger; at most `iterations` accepted or refused steps. n >= 3. */
LT_API lt_status lt_pnp_refine(const lt_camera *cam, int n, const double *X, const double *uv,
                               int iterations, double R[9], double t[3]);

/* lt_pnp_error - mean distance in pixels between uv and the projected X; infinite if one is not in front */
LT_API double lt_pnp_error(const lt_camera *cam, int n, const double *X, const double *uv,
                           const double R[9], const double t[3]);

/* Begin with one of the two functions below and change what you must. */
typedef struct {
    int iterations;             /* 100: draws at most */
    double inlier_px;           /* 8: an inlier is reprojected this near or nearer */
    double confidence;          /* 0.99: stop when a draw of inliers alone has been likely this much */
    uint64_t seed;              /* 0 */
    int min_inliers;            /* 5; refined: 6. Fewer is no pose. */
    double min_scatter;         /* 0; refined: 1e-3. A draw is refused when its object points' smallest
                                 * covariance eigenvalue is under this share of the second, or when two
                                 * of its points are one; 0 takes any draw. */
    double thin;                /* 0; refined: 0.05. Points whose bounding box is thinner than this share
                                 * of its next extent are solved by homography, not EPnP. */
    int refine_iterations;      /* 0; refined: 20. Levenberg-Marquardt steps on the inliers at the end. */
    double min_depth_m;         /* 0; refined: 0.05. A translation nearer than this is no pose. */
} lt_pnp_opts;

/* lt_pnp_opencv - what OpenCV's solvePnPRansac does by default with SOLVEPNP_EPNP; but see lt_pnp_ransac on the fit to
 * all inliers */
LT_API lt_pnp_opts lt_pnp_opencv(void);

/* lt_pnp_refined - the same with the guards and the refinement in the comments above */
LT_API lt_pnp_opts lt_pnp_refined(void);

typedef struct {
    double R[9], t[3];
    int n_inliers;
    double mean_err_px;         /* over the inliers, under R and t */
} lt_pnp_pose;

/**
 * lt_pnp_ransac - pose of n >= 6 points of which some are wrong
 *
 *   inlier   (n) or NULL; set to 1 for the points that the final pose was made from, else 0
 *
 * Draws five distinct points, solves, counts inliers; keeps the first draw with the most; caps the draws
 * by log(1 - confidence) / log(1 - w^5), w the best share of inliers; solves again on the inliers, and keeps
 * the draw's pose where their mean error is above inlier_px after that.
 * The same input gives the same pose: draws are a function of opts->seed. opts NULL means lt_pnp_opencv().
 *
 * Source: Fischler and Bolles 1981; opencv modules/calib3d/src/solvepnp.cpp and ptsetreg.cpp.
 */
LT_API lt_status lt_pnp_ransac(const lt_camera *cam, int n, const double *X, const double *uv,
                               const lt_pnp_opts *opts, lt_pnp_pose *pose, unsigned char *inlier);

#ifdef __cplusplus
}
#endif
#endif
