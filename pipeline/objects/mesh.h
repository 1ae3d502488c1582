/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A user's model of an object: a folder with a mesh, and perhaps points of its surface.
 */
#ifndef PIPELINE_OBJECTS_MESH_H
#define PIPELINE_OBJECTS_MESH_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/box21.h"
#include "libtensor/geometry/mesh/mesh.h"

/**
 * object_mesh_read - textured_simple.obj, else textured.obj, else the only .obj or .ply of the folder
 *
 *   points   the box of points.xyz, or where there is none of points drawn from the surface
 *
 * Numbers are the files' own, whatever unit those have. Errors: LT_EFORMAT: no mesh, several, one without triangles or
 * area; LT_EIO, LT_ENOMEM.
 */
lt_status object_mesh_read(lt_arena *arena, const char *folder, lt_mesh *mesh, lt_box *points);

/* What a model's numbers are, compared with what a hand holds. */
typedef struct {
    double scale;                   /* what makes metres of them; 0: nothing known does */
    const char *unit;               /* "millimetres"; NULL: metres, or not known */
} object_unit;

/**
 * object_unit_of - the unit of a model, by its size
 *
 *   longest   side of its box
 *   known     in metres, of the object that it should be; 0: any that a hand holds, of 5 mm to 2 m
 *
 * A known object is told apart in metres, millimetres, centimetres and inches, any other in metres and millimetres
 * alone: 19 may be a bottle in centimetres, and a nut in millimetres.
 */
object_unit object_unit_of(double longest, double known);

/**
 * object_turn_of - what turns a known object's box and centre into the model's
 *
 *   turn     row i holds which axis of the known object the model's axis i is, with its sign: { 1, 3, -2 }
 *
 * Returns whether there is such a turn: sides agree to a tenth or 5 mm. Of several the one whose centre agrees best,
 * and where none does to 15 mm, since a model may have been moved, the first; the same axes go before all others.
 */
bool object_turn_of(const double size[3], const double centre[3], const double known_size[3],
                    const double known_centre[3], int turn[3]);

#endif
