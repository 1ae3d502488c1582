/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PLY: meshes, points with any properties, and 3D Gaussians as the viewers of splats take them.
 *
 * Source: Turk 1994, "The PLY polygon file format"; graphdeco-inria/gaussian-splatting scene/gaussian_model.py
 * for the vertex of a Gaussian.
 */
#ifndef LT_IO_MESH_PLY_H
#define LT_IO_MESH_PLY_H

#include "libtensor/geometry/mesh/mesh.h"
#include "libtensor/io/array/array.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One column. Of a list, row i has the values from begin[i] up to begin[i + 1]. */
typedef struct {
    const char *name;
    bool is_list;
    lt_array values;                /* rank 1; i1, u1, i2, u2, i4, u4, f4 or f8 */
    const uint32_t *begin;          /* count + 1 of them; NULL for a plain property */
} lt_ply_property;

typedef struct {
    const char *name;               /* "vertex", "face" */
    size_t count;                   /* rows */
    int n;
    lt_ply_property *property;
} lt_ply_element;

typedef struct {
    const char *path;               /* for error lines */
    const char *format;             /* "ascii", "binary_little_endian", "binary_big_endian" */
    int n;
    lt_ply_element *element;
} lt_ply;

/**
 * lt_ply_read - all elements of a PLY file, in text or either byte order
 *
 *   out      owned by the arena; touched only on success
 *
 * Comments are skipped; bytes behind the last row are not looked at.
 * Errors: LT_EFORMAT with line or offset: no PLY header, more than 64 elements or 512 properties, an
 * unknown type, a name twice, more rows than the file can hold, a list of more than 255 values, a number
 * that its type cannot hold. LT_EIO, LT_ENOMEM.
 */
LT_API lt_status lt_ply_read(lt_arena *arena, const char *path, lt_ply *out);

/* lt_ply_parse - the same from n bytes in memory */
LT_API lt_status lt_ply_parse(lt_arena *arena, const char *name, const uint8_t *bytes, size_t n, lt_ply *out);

/* lt_ply_find - a property by element and name, NULL when there is none; *count (may be NULL): its rows */
LT_API const lt_ply_property *lt_ply_find(const lt_ply *p, const char *element, const char *name, size_t *count);

/**
 * lt_ply_mesh - the file as a mesh, in the arena
 *
 * vertex: x y z; nx ny nz, u v (also s t, texture_u texture_v) and red green blue where there are all of a
 * kind; integer colours become 0..1. face: vertex_indices (also vertex_index); polygons become fans. A file
 * without faces is a mesh of points.
 * Errors: LT_EFORMAT: no vertices, a number that is not finite, an index of a vertex that is not there.
 */
LT_API lt_status lt_ply_mesh(lt_arena *arena, const lt_ply *p, lt_mesh *out);

/**
 * lt_ply_write_mesh - a mesh as little-endian PLY, atomically; reads back to the same bits
 *
 * Colours that are all whole 255ths are written as bytes, which viewers expect, others as floats.
 */
LT_API lt_status lt_ply_write_mesh(const char *path, const lt_mesh *mesh);

/* One Gaussian, as it lies in a file: 62 floats, 248 bytes. */
typedef struct {
    float x[3], normal[3];
    float dc[3];                    /* spherical harmonics of degree 0: red, green, blue */
    float rest[3][15];              /* degrees 1 to 3 of each colour */
    float opacity;                  /* before the sigmoid */
    float scale[3];                 /* logarithms */
    float rotation[4];              /* w x y z, not necessarily of length 1 */
} lt_splat;

/**
 * lt_ply_splats - the file as Gaussians, in the arena
 *
 * Properties may stand in any order, with others between. Normals may be absent, and so may the higher
 * degrees of the harmonics (f_rest of 0, 9, 24 or 45 numbers); what is absent is 0.
 * Errors: LT_EFORMAT: a property that must be there is not, a number that is not finite.
 */
LT_API lt_status lt_ply_splats(lt_arena *arena, const lt_ply *p, lt_splat **out, size_t *n);

/* lt_ply_write_splats - n Gaussians with all 62 properties, as viewers want them, atomically. frame: a comment that
 * says which axes they are in ("opencv camera, metres") */
LT_API lt_status lt_ply_write_splats(const char *path, const char *frame, const lt_splat *splat, size_t n);

#ifdef __cplusplus
}
#endif
#endif
