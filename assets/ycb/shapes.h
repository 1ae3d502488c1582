/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The shapes in millimetres, each in its own frame around the origin, and their way into the model's.
 */
#ifndef ASSETS_YCB_SHAPES_H
#define ASSETS_YCB_SHAPES_H

#include "assets/ycb/loft.h"

/* From a shape's own millimetres to the model's metres: turned about z, stretched a little, moved. */
typedef struct { double cos_yaw, sin_yaw, scale[3], offset[3]; } synth_placement;

/* synth_place_point - out may be local */
void synth_place_point(const synth_placement *p, const double local[3], double out[3]);

/* synth_object_build - synth_object_new that also tells where the shape was put */
lt_status synth_object_build(lt_arena *arena, int id, lt_mesh *mesh, synth_placement *placement);

/* synth_shape_build - add the parts of an object, 1 .. SYNTH_OBJECTS */
void synth_shape_build(loft_builder *b, int id);

#endif
