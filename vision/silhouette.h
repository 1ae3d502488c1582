/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a mesh covers in an image, hidden parts included, and how far away it is there.
 */
#ifndef VISION_SILHOUETTE_H
#define VISION_SILHOUETTE_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * silhouette_draw - set mask to 1 where a triangle of the posed mesh covers a pixel's centre
 *
 *   R (9), t (3)   x_cam = R x + t, row-major, metres, OpenCV axes
 *   mask           (height, width); pixels not covered keep their value
 *   scratch        for the projected vertices
 *
 * Triangles are filled from both sides. One that reaches nearer than 1 cm to the camera is left out.
 * Errors: no memory.
 */
lt_status silhouette_draw(const lt_mesh *mesh, const float *R, const float *t, const lt_camera *cam,
                          uint8_t *mask, int width, int height, lt_arena *scratch);

/**
 * silhouette_depth - the depth of the posed mesh's nearest surface at each pixel's centre
 *
 *   depth          (height, width) metres along the optical axis, all written: 0 where no triangle is
 *
 * Otherwise as silhouette_draw.
 */
lt_status silhouette_depth(const lt_mesh *mesh, const float *R, const float *t, const lt_camera *cam,
                           float *depth, int width, int height, lt_arena *scratch);

#ifdef __cplusplus
}
#endif
#endif
