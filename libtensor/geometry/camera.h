/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pinhole camera, the axes of datasets, and the affine maps that crop images.
 *
 * Axes are OpenCV's: x right, y down, z forward; metres. Pixel centres have integer coordinates. No lens
 * distortion: the datasets' images are rectified.
 */
#ifndef LT_GEOMETRY_CAMERA_H
#define LT_GEOMETRY_CAMERA_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double fx, fy, cx, cy;          /* pixels */
} lt_camera;

/**
 * lt_camera_project - the pixel where the camera sees point p
 *
 * Returns whether p lies in front of the camera (z > 1e-9). uv is finite in any case: behind the camera
 * it is the mirrored formula, at z = 0 the principal point.
 */
LT_API bool lt_camera_project(const lt_camera *cam, const double p[3], double uv[2]);

/* lt_camera_backproject - the point at depth z (along the optical axis) that is seen at uv */
LT_API void lt_camera_backproject(const lt_camera *cam, const double uv[2], double z, double p[3]);

/* lt_camera_crop - the camera A K of an image mapped by the affine A, which must not rotate or shear */
LT_API lt_camera lt_camera_crop(const lt_camera *cam, const double A[6]);

/* ---- OpenGL axes (HO3D) <-> OpenCV axes; F = diag(1, -1, -1) is its own inverse ------------------- */

/* lt_flip_yz - p = F p, in place */
LT_API void lt_flip_yz(double p[3]);

/* lt_flip_yz_pose - R = F R, t = F t, in place: an object's pose. Points stay in the model's frame. */
LT_API void lt_flip_yz_pose(double R[9], double t[3]);

/**
 * lt_flip_yz_mano - a MANO pose in the other axes, in place
 *
 *   root   axis-angle of the wrist        root' = F root
 *   t      MANO's translation, metres     t' = F (J0 + t) - J0
 *   J0     wrist of the unposed hand with the sample's betas
 *
 * MANO turns the hand about its wrist, not about the origin, so F t alone would be off by F J0 - J0.
 */
LT_API void lt_flip_yz_mano(double root[3], double t[3], const double J0[3]);

/* lt_mirror_axis_angle - the rotation seen in the mirror x -> -x: (a, b, c) -> (a, -b, -c), in place.
 * This is how a left hand's pose becomes a right hand's. */
LT_API void lt_mirror_axis_angle(double aa[3]);

/* ---- affine maps of the image: q = A (p, 1), A row-major (2, 3) ----------------------------------- */

/**
 * lt_affine_crop - the map from an image to a square crop of it
 *
 *   cx, cy, side   the window in image pixels
 *   phi            rotation about the image's origin, radians: R = [cos -sin; sin cos]
 *   size           pixels along a side of the crop
 *
 * The window's centre goes to (size/2, size/2).
 */
LT_API void lt_affine_crop(double cx, double cy, double side, double phi, double size, double A[6]);

/* lt_affine_inverse - LT_EINVAL when A has no inverse; then out is untouched. out may be A. */
LT_API lt_status lt_affine_inverse(const double A[6], double out[6]);

/* lt_affine_apply - q = A (p, 1); q may be p */
LT_API void lt_affine_apply(const double A[6], const double p[2], double q[2]);

#ifdef __cplusplus
}
#endif
#endif
