/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Boxes around points, the square window to crop, and what the affine map from image to crop (A, row-major
 * (2, 3), as in libtensor/geometry/camera.h) does to points, intrinsics, images and masks.
 *
 * Source: the sample preparation of Semi-Hand-Object and HFL-Net (dataset/dataset_util.py), which HOCAT
 * keeps.
 */
#ifndef VISION_CROP_H
#define VISION_CROP_H

#include "libtensor/geometry/camera.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct { float x0, y0, x1, y1; } crop_box;

/* The square to cut out: centre and side in image pixels, and the angle to turn the image by. */
typedef struct { double cx, cy, side, angle; } crop_window;

/* crop_box_around - the extent of n points about its centre (cut to whole pixels), times factor,
 * x and y apart. n >= 1. */
crop_box crop_box_around(const float (*point)[2], int n, double factor);

/* crop_window_around - the square that holds hand and object, clamped to the image; angle 0 */
crop_window crop_window_around(crop_box hand, crop_box object, int width, int height);

/* crop_window_hull - the square about the middle of box, with the box's longer side; angle 0 */
crop_window crop_window_hull(crop_box box);

/* crop_extent - the smallest box with n points in it; n >= 1 */
crop_box crop_extent(const float (*point)[2], int n);

/* crop_affine - the map of window w onto size x size pixels: turned about the image's origin by w.angle,
 * scaled by size / side, the centre put in the middle */
void crop_affine(crop_window w, int size, double A[6]);

/* crop_inverse - the map from crop to image; a window's map always has one. back may be A. */
void crop_inverse(const double A[6], double back[6]);

/* crop_place - where in the image the centre of crop pixel (x, y) lies; back is crop_inverse's */
static inline void crop_place(const double back[6], int x, int y, double p[2])
{
    p[0] = x + 0.5;
    p[1] = y + 0.5;
    lt_affine_apply(back, p, p);
}

/* crop_source - the number of the image's pixel at that place, row by row; -1: it lies outside */
static inline int64_t crop_source(const double back[6], int width, int height, int x, int y)
{
    double p[2];

    crop_place(back, x, y, p);
    if (!(p[0] >= 0 && p[0] < width && p[1] >= 0 && p[1] < height))
        return -1;
    return (int64_t)p[1] * width + (int64_t)p[0];
}

/* crop_points - n points mapped by A */
void crop_points(const double A[6], const float (*in)[2], int n, float (*out)[2]);

/* crop_corners - the two corners of b mapped by A, which must not turn */
crop_box crop_corners(const double A[6], crop_box b);

/* crop_intrinsics - K' = A K (3, 3), row-major, which may turn: so no lt_camera */
void crop_intrinsics(const double A[6], const lt_camera *cam, float *out);

/* crop_whole_camera - the image's camera back from K' = A K, where A does not turn */
lt_camera crop_whole_camera(const float A[6], const float K[9]);

/* crop_normalise - points in units of box: (0,0) its low corner, (1,1) its high one. An empty box is
 * taken as one pixel wide. */
void crop_normalise(crop_box box, const float (*in)[2], int n, float (*out)[2]);

/**
 * crop_warp - cut out the window: the image under A, `outside` around it
 *
 *   rgb   (height, width, 3)
 *   outside  red, green, blue in [0, 1]; NULL: black
 *   out   (3, size, size) in [0, 1]
 *
 * Nearest: the centre (x + 0.5, y + 0.5) of an output pixel is mapped back and cut to whole pixels.
 * With bilinear the four pixels around are mixed instead.
 */
void crop_warp(const double A[6], const uint8_t *rgb, int width, int height, const float outside[3], float *out,
               int size, bool bilinear);

/**
 * crop_mask - the part of mask inside box, on a cells x cells grid
 *
 *   mask  (height, width); box in crop pixels, rounded to whole ones; out (cells, cells), 0 or 1
 *
 * mask is warped as crop_warp does, cut at box (0 outside the crop), and resized to the nearest.
 */
void crop_mask(const double A[6], const uint8_t *mask, int width, int height, int size,
               crop_box box, float *out, int cells);

#ifdef __cplusplus
}
#endif
#endif
