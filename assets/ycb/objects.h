/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Procedural stand-ins for the YCB objects: meshes with the true sizes, symmetries and frames, labels in
 * the true colours, and the sampled points that metrics use. They are not the scanned models. And a jug, for what
 * must not see the pitcher and has to learn how a whole hand holds a handle.
 */
#ifndef ASSETS_YCB_OBJECTS_H
#define ASSETS_YCB_OBJECTS_H

#include "assets/ycb/ycb.h"
#include "libtensor/base/arena.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    SYNTH_TEXTURE = 512,            /* pixels, both ways */
    SYNTH_POINTS = 2621,            /* lines of a points.xyz */
    SYNTH_JUG = YCB_COUNT + 1,      /* ids are YCB's, and this one */
    SYNTH_OBJECTS = SYNTH_JUG,
};

/* synth_object_find - name, size and symmetry of an id, or NULL outside 1 .. SYNTH_OBJECTS */
const ycb_object *synth_object_find(int id);

/**
 * synth_object_new - the mesh of an object's stand-in
 *
 *   mesh     metres, 1000 to 3000 vertices with uv; owned by the arena
 *
 * The mesh is one or more closed manifold parts, faces outwards; parts (a mug and its handle) may overlap,
 * and the object is their union. Size, centre and yaw are those of synth_object_find: every side of the
 * box to 1.5 mm, the diameter to 2 %.
 *
 * Errors: LT_EINVAL for an id outside 1 .. SYNTH_OBJECTS, LT_ENOMEM.
 */
lt_status synth_object_new(lt_arena *arena, int id, lt_mesh *mesh);

/**
 * synth_object_texture - the label that belongs to the mesh's uv
 *
 *   rgb      SYNTH_TEXTURE rows of SYNTH_TEXTURE sRGB pixels; the top row is v = 1; owned by the arena
 *
 * Colours are the object's own; the print is drawn by its id, the same in every dataset, and breaks the
 * symmetry of every object whose class does not hold for the texture.
 *
 * Errors: as above.
 */
lt_status synth_object_texture(lt_arena *arena, int id, uint8_t (**rgb)[3]);

/**
 * synth_object_points - SYNTH_POINTS points spread over the surface, each as far as can be from the others
 *
 *   point    metres, in the frame of the mesh; point[0] is a fixed draw; owned by the arena
 *
 * Where parts overlap, the few points inside another part stay.
 *
 * Errors: LT_ENOMEM.
 */
lt_status synth_object_points(lt_arena *arena, const lt_mesh *mesh, float (**point)[3]);

#ifdef __cplusplus
}
#endif
#endif
