/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The surface at which a field over tetrahedra crosses a level.
 */
#ifndef LT_GEOMETRY_MARCHING_H
#define LT_GEOMETRY_MARCHING_H

#include "libtensor/base/arena.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Its vertices lie on edges of the tetrahedra, one on each that it crosses, where the field is found to cross there. */
typedef struct {
    int64_t n_vertices, n_faces;
    int32_t (*edge)[2];             /* (n_vertices) points of the tetrahedra: one inside, one outside */
    int32_t (*face)[3];             /* (n_faces) of vertices, which turn to the left seen from outside */
} lt_level_surface;

/**
 * lt_marching_tetrahedra - where value crosses level, in arena memory
 *
 *   tet      (n) points of each, right-handed as lt_delaunay has them
 *   value    of each point; above level is inside; NaN is outside
 *
 * Inside of the hull the surface is closed: each edge belongs to two faces. Errors: LT_ENOMEM.
 *
 * Source: Doi and Koide 1991, "An efficient method of triangulating equi-valued surfaces by using tetrahedral cells".
 */
LT_API lt_status lt_marching_tetrahedra(lt_arena *arena, int64_t n, const int32_t (*tet)[4], const double *value,
                                        double level, lt_level_surface *out);

#ifdef __cplusplus
}
#endif
#endif
