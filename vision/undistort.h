/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pictures as a pinhole camera would have taken them.
 */
#ifndef VISION_UNDISTORT_H
#define VISION_UNDISTORT_H

#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/lens.h"
#include "vision/crop.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A camera with a lens, and the size of its pictures. */
typedef struct {
    lt_camera camera;
    lt_lens lens;
    int width, height;
} undistortion;

/* undistort_rgb - rgb (height, width, 3) into out, between pixels; black where the lens saw nothing */
void undistort_rgb(const undistortion *u, const uint8_t *rgb, uint8_t *out);

/* undistort_depth - metres (height, width) into out, at the nearest pixel; 0, unknown, where the lens saw nothing */
void undistort_depth(const undistortion *u, const float *depth, float *out);

/* undistort_box - around what lies in a box of the distorted picture */
crop_box undistort_box(const undistortion *u, crop_box box);

/* undistort_fold - how far from the principal point, in pixels of the focal length, the lens folds its picture back
 * (lt_lens_fold); infinity: nowhere in the picture */
double undistort_fold(const undistortion *u);

#ifdef __cplusplus
}
#endif
#endif
