/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Meshes and points in text files: Wavefront OBJ and .xyz.
 */
#ifndef LT_IO_MESH_OBJ_H
#define LT_IO_MESH_OBJ_H

#include "libtensor/base/arena.h"
#include "libtensor/base/status.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * lt_obj_read - the triangles of an OBJ file
 *
 *   out      arrays in the arena; touched only on success
 *   texture  the path of the diffuse image (map_Kd) of the first material used, in the arena, or NULL
 *            when there is none, it is not a plain name inside the file's folder, or its .mtl is
 *            missing; pass NULL if not wanted
 *
 * Polygons become fans. A vertex that is used with several texture or normal indices is split; the
 * first n of the result are the file's "v" lines in order, copies follow. Colours are those of
 * "v x y z r g b". uv has its origin at the lower left, as in the file. normal is there when every
 * corner has one, uv likewise.
 *
 * Errors: LT_EFORMAT with "path:line: reason": not a number, NaN or infinity, an index of a vertex
 * that is not there, fewer than 3 corners, more than 20 million lines. LT_EIO, LT_ENOMEM.
 */
LT_API lt_status lt_obj_read(lt_arena *arena, const char *path, lt_mesh *out, const char **texture);

/**
 * lt_obj_write - vertices, their colours, uv and normals where there are any, and triangles, atomically
 *
 *   texture  the name of an image file in the same folder; then "stem.mtl" is written too. Or NULL.
 */
LT_API lt_status lt_obj_write(const char *path, const lt_mesh *mesh, const char *texture);

/**
 * lt_xyz_read - three numbers a line, further columns ignored; blank lines and '#' comments skipped
 *
 *   points   n of them, in the arena
 */
LT_API lt_status lt_xyz_read(lt_arena *arena, const char *path, float (**points)[3], size_t *n);
LT_API lt_status lt_xyz_write(const char *path, const float (*points)[3], size_t n);

#ifdef __cplusplus
}
#endif
#endif
