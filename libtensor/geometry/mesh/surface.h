/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Questions to a triangle mesh: normals, area, the nearest point, inside or outside, samples.
 *
 * Faces must name vertices that exist (readers see to it). Points are double, metres.
 */
#ifndef LT_GEOMETRY_MESH_SURFACE_H
#define LT_GEOMETRY_MESH_SURFACE_H

#include "libtensor/base/arena.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lt_mesh_normals - fills normal (n_vertices, 3) with the area-weighted mean of the faces around each
 * vertex, unit length; (0, 0, 1) where there is none. normal may be mesh->normal. */
LT_API void lt_mesh_normals(const lt_mesh *mesh, float (*normal)[3]);

/* lt_mesh_area - square metres */
LT_API double lt_mesh_area(const lt_mesh *mesh);

/* lt_closest_on_triangle - the point of triangle abc nearest to p, also when the triangle is degenerate */
LT_API void lt_closest_on_triangle(const double p[3], const double a[3], const double b[3],
                                   const double c[3], double out[3]);

/* A tree of boxes over a mesh's triangles. Read-only once made: any number of threads may ask. */
typedef struct lt_mesh_index lt_mesh_index;

/* lt_mesh_index_new - in the arena; positions are copied, so that the mesh may go. LT_EINVAL when the mesh
 * has no face, a face names no vertex, or a coordinate is not finite; LT_ENOMEM. */
LT_API lt_status lt_mesh_index_new(lt_arena *arena, const lt_mesh *mesh, lt_mesh_index **out);

typedef struct {
    double point[3];
    double distance;            /* metres, never negative */
    int face;
} lt_mesh_hit;

/* lt_mesh_closest - the point of the surface nearest to p; the lowest face when several are equally near */
LT_API lt_mesh_hit lt_mesh_closest(const lt_mesh_index *index, const double p[3]);

/**
 * lt_mesh_inside - whether p is inside the surface
 *
 * Counts crossings along three rays and believes the majority, so a closed mesh is always answered, and
 * one with small holes (a hand's wrist) mostly. Orientation of faces does not matter.
 */
LT_API bool lt_mesh_inside(const lt_mesh_index *index, const double p[3]);

/**
 * lt_mesh_winding - how often the surface goes around p
 *
 * 1 inside a closed mesh, 0 outside, 2 where two parts of it overlap; the sign is minus where faces look inwards. A
 * mesh with holes gives fractions, so p is inside where it is above 1/2. Faces that are far from p are summed together:
 * right to 0.01.
 *
 * Source: Jacobson et al. 2013; Barill et al. 2018, with terms up to the second.
 */
LT_API double lt_mesh_winding(const lt_mesh_index *index, const double p[3]);

/* lt_mesh_sample - n points (n, 3) uniform over the area, and the face of each (n) unless face is NULL.
 * LT_EINVAL when the mesh has no area; LT_ENOMEM. */
LT_API lt_status lt_mesh_sample(const lt_mesh *mesh, lt_rng *rng, int n, float (*points)[3], int *face);

/**
 * lt_farthest_points - choose k of n points (n, 3), each the farthest from those before; chosen (k) holds
 * their indices, the first is `first`. Ties go to the lower index. O(n k).
 *
 * LT_EINVAL when k > n, k < 0, or first is no point; LT_ENOMEM.
 */
LT_API lt_status lt_farthest_points(int n, const float (*points)[3], int k, int first, int *chosen);

#ifdef __cplusplus
}
#endif
#endif
