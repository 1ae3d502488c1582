/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A hand and an object in camera coordinates, drawn over what the camera saw.
 */
#ifndef VISION_DRAWING_POSE_H
#define VISION_DRAWING_POSE_H

#include "libtensor/geometry/camera.h"
#include "libtensor/geometry/hand/model.h"
#include "libtensor/geometry/mesh/mesh.h"
#include "libtensor/geometry/pose.h"
#include "vision/drawing/draw.h"

/* Whatever is NULL is not drawn. Metres, camera axes. */
typedef struct {
    const float (*joints)[3];       /* (21, 3) simple order */
    const float (*vertices)[3];     /* (778, 3) */
    const int32_t (*faces)[3];      /* (1538, 3); needed with vertices */
    const lt_pose *object;
    const float (*control)[3];      /* (21, 3) of the object's box, its own frame; needed with object */
    const lt_mesh *mesh;            /* the object's outline; may be NULL with object */
    const float (*control2d)[2];    /* (21, 2) of the object's box in pixels, for want of an object; NaN: none */
} pose_drawing;

/* pose_project - n points to pixels; NaN for those not in front of the camera, which drawing leaves out */
void pose_project(const lt_camera *cam, const float (*point)[3], int n, float (*uv)[2]);

/* pose_draw - width: of the finest lines, in pixels; 1 for a picture of some 500. LT_ENOMEM. */
lt_status pose_draw(lt_arena *scratch, draw_canvas *c, const lt_camera *cam, const pose_drawing *p,
                    float width);

#endif
