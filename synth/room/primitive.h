/* SPDX-License-Identifier: Apache-2.0 */
/* The simple solids of which a room is made. z is up; each stands on z = 0 unless said. */
#ifndef SYNTH_ROOM_PRIMITIVE_H
#define SYNTH_ROOM_PRIMITIVE_H

#include "synth/room/room.h"

/* A mesh with room for n vertices and faces, all with normals and uv; n_vertices 0 without memory. */
lt_mesh primitive_alloc(lt_arena *arena, int n_vertices, int n_faces);

/* A box with rounded edges. uv: the four sides share the left part of the image side by side, top and
 * bottom the right. */
lt_mesh primitive_box(lt_arena *arena, const double size[3], double edge);

/* A profile of n points (radius, z) turned about z, from the bottom of the outside upwards; corners
 * sharper than 40 degrees stay sharp. u runs around, v along the profile. */
lt_mesh primitive_lathe(lt_arena *arena, const float (*profile)[2], int n, int segments);

/* A tube of n rings along a path; radius at each. Ends are open. Sections may be flattened: the
 * second semi-axis, along side, is flat times the first. */
lt_mesh primitive_tube(lt_arena *arena, const float (*path)[3], const float *radius, int n, float flat,
                       const float side[3], int segments);

/* A rectangle in the xy plane about the origin, its front towards +z; uv 0..repeat. */
lt_mesh primitive_sheet(lt_arena *arena, double width, double depth, double repeat_u, double repeat_v);

/* A regular grid of rings by points, closed around: vertices must be filled in; makes faces, and
 * normals from the neighbours. Outwards is where the grid turns about its direction of growth. */
void primitive_weave(lt_mesh *mesh, int rings, int around);

#endif
