/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Delaunay tetrahedra of points in space: no point lies inside of the sphere around any of them, and together they fill
 * the points' hull.
 */
#ifndef LT_GEOMETRY_DELAUNAY_H
#define LT_GEOMETRY_DELAUNAY_H

#include "libtensor/base/arena.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { LT_DELAUNAY_BITS = 22, LT_DELAUNAY_MOST = 100000000 };

typedef struct {
    int64_t n;
    int32_t (*tet)[4];              /* (n) points of each, right-handed: (b - a) x (c - a) . (d - a) > 0 */
    int32_t *same;                  /* of each point the one that stands for it: itself, or another one at its place */
    int32_t (*grid)[3];             /* where each point is taken to be, in steps from lo */
    double lo[3], step;             /* metres, or whatever the points are in */
} lt_tetrahedra;

/**
 * lt_delaunay - of n points, in arena memory
 *
 * Points are moved to a grid of 2^22 steps along the longest side of their box, a quarter of a millionth of it, and
 * there everything is exact; points of one grid place are one. Where five points lie on a sphere the order of their
 * places decides, so there is one answer, whatever the order of the points. The same bits everywhere.
 *
 * Errors: LT_EINVAL: fewer than four points, more than LT_DELAUNAY_MOST, one that is not finite, all of them in one
 * plane; LT_ENOMEM.
 *
 * Source: Bowyer 1981, Watson 1981; ties as in Devillers and Teillaud 2003, "Perturbations and vertex removal in a 3D
 * Delaunay triangulation"; insertion in rounds along Hilbert's curve, Amenta et al. 2003.
 */
LT_API lt_status lt_delaunay(lt_arena *arena, int64_t n, const double (*point)[3], lt_tetrahedra *out);

#ifdef __cplusplus
}
#endif
#endif
