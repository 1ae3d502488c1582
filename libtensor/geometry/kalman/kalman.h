/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Kalman filters that smooth what is measured frame by frame and bridge frames without: points (the joints of a
 * hand), and the 6D pose of a body. Metres, radians, seconds; one frame of reference for all calls.
 */
#ifndef LT_GEOMETRY_KALMAN_KALMAN_H
#define LT_GEOMETRY_KALMAN_KALMAN_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- a point: position and velocity of each axis on its own ------------------------------------------------ */

/* Zeroed: nothing was measured yet. */
typedef struct {
    double x[3], v[3];
    double P[3][3];                 /* by axis: variance of x, covariance, variance of v */
    int rejected;                   /* measurements in a row that were too far off */
    bool started;
} lt_point_filter;

/**
 * lt_point_filter_step - dt seconds on, then the measurement; f->x is the estimate
 *
 *   measured  (3), or NULL where there is none
 *
 * Returns whether the measurement counted. One whose normalised squared innovation is above 11.345 (99 % of
 * three degrees of freedom) does not; the third of those in a row starts the filter anew. Before the first
 * measurement nothing happens. Acceleration has 8 m/s^2, a measurement 8 mm deviation.
 * Source: Bandi and Thomas 2025, section 3; Bar-Shalom et al. 2001, section 6.3.
 */
LT_API bool lt_point_filter_step(lt_point_filter *f, double dt, const double *measured);

/* ---- a pose: an error-state filter on the unit sphere of quaternions ----------------------------------------- */

enum { LT_POSE_STATES = 12, LT_POSE_COAST = 15 };

typedef enum {
    LT_FILTER_OFF,                  /* nothing is known */
    LT_FILTER_ON,                   /* the last measurement counted */
    LT_FILTER_COAST,                /* predicted alone */
} lt_filter_state;

/* Zeroed: off. Quaternions are (w, x, y, z): x_world = q x_object q* + p. */
typedef struct {
    double p[3], v[3], q[4], w[3];              /* place, velocity, orientation, angular velocity in the world */
    double P[LT_POSE_STATES][LT_POSE_STATES];   /* of the errors of p, v, orientation (world axes), w */
    lt_filter_state state;
    int missed;                     /* frames in a row without a measurement that counted */
} lt_pose_filter;

typedef struct {
    double p[3], q[4];              /* q of any length but 0 */
    double R_world_cam[9];          /* row-major: depth is the least certain axis of a camera */
    double reprojection_px;         /* mean error of the points it was found from; above 4 it counts for less */
    const double (*symmetry)[4];    /* (n_symmetries) turns of the object that look the same; NULL: none but itself */
    int n_symmetries;
} lt_pose_measurement;

/**
 * lt_pose_filter_step - dt seconds on, then the measurement
 *
 *   m   NULL where there is none. Of its orientation and those that look the same the nearest counts.
 *
 * Returns f->state. A measurement does not count that is no pose (not finite, q of length 0), or whose normalised
 * squared innovation is above 16.812 (99 % of six degrees of freedom); after LT_POSE_COAST frames without one that
 * counts the filter is off, and the next one starts it. Deviations: acceleration 2 m/s^2, 10 rad/s^2; a measurement
 * 5 mm across, 15 mm along the camera's axis, 5 degrees.
 * Source: as above; Sola 2017, "Quaternion kinematics for the error-state Kalman filter", sections 5 to 7.
 */
LT_API lt_filter_state lt_pose_filter_step(lt_pose_filter *f, double dt, const lt_pose_measurement *m);

#ifdef __cplusplus
}
#endif
#endif
