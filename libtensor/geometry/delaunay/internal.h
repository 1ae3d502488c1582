/* SPDX-License-Identifier: Apache-2.0 */
/* Signs of determinants of places on the grid, and the order in which points go in. */
#ifndef LT_GEOMETRY_DELAUNAY_INTERNAL_H
#define LT_GEOMETRY_DELAUNAY_INTERNAL_H

#include "libtensor/geometry/delaunay/delaunay.h"

typedef const int32_t *grid_place;

/* delaunay_orient - 1 where d lies on the side of a, b, c from which they turn to the left, -1 on the other one, 0 in
 * their plane: the sign of (b - a) x (c - a) . (d - a) */
int delaunay_orient(grid_place a, grid_place b, grid_place c, grid_place d);

/* delaunay_insphere - 1 where e lies inside the sphere around a, b, c, d, which are right-handed, -1 outside, never 0:
 * on it the places' order decides */
int delaunay_insphere(grid_place a, grid_place b, grid_place c, grid_place d, grid_place e);

/* delaunay_order - of n points: rounds that double, each along Hilbert's curve. Errors: LT_ENOMEM. */
lt_status delaunay_order(lt_arena *arena, int64_t n, const int32_t (*grid)[3], int32_t **out);

#endif
