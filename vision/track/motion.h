/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How a box moves: DeepSORT's Kalman filter of constant velocity over centre, aspect and height. All its matrices are
 * diagonal but for position and velocity of one quantity, so it is four filters of two states each.
 *
 * Source: Wojke et al. 2017, "Simple online and realtime tracking with a deep association metric", section 2.1.
 */
#ifndef VISION_TRACK_MOTION_H
#define VISION_TRACK_MOTION_H

#ifdef __cplusplus
extern "C" {
#endif

enum { MOTION_X, MOTION_Y, MOTION_ASPECT, MOTION_HEIGHT, MOTION_AXES };

typedef struct {
    double x, v;                    /* value, and what it gains a frame */
    double P[3];                    /* variance of x, covariance, variance of v */
} motion_axis;

typedef struct { motion_axis axis[MOTION_AXES]; } box_motion;

/* motion_begin - at rest at a box x0 y0 x1 y1 */
void motion_begin(box_motion *m, const float box[4]);

/* motion_predict - one frame on */
void motion_predict(box_motion *m);

/* motion_distance - the squared Mahalanobis distance of a box from where it is expected; what is no number is far */
double motion_distance(const box_motion *m, const float box[4]);

/* motion_update - a box was measured */
void motion_update(box_motion *m, const float box[4]);

/* motion_box - the box as it is now, x0 y0 x1 y1 */
void motion_box(const box_motion *m, double box[4]);

#ifdef __cplusplus
}
#endif
#endif
