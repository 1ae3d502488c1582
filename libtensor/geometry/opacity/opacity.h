/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The opacity field of Gaussians: how much of them stands between a place and those who look at it from all around; and
 * the surface at which it crosses a level.
 */
#ifndef LT_GEOMETRY_OPACITY_H
#define LT_GEOMETRY_OPACITY_H

#include "libtensor/base/arena.h"
#include "libtensor/geometry/mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One Gaussian. Its covariance is M M^T of the matrix M (3, 3) by rows, with an axis in each column: a rotation times
 * deviations, or what has become of it under any linear map. Metres. */
typedef struct {
    double centre[3], axes[9], opacity;
} lt_gaussian;

typedef enum {
    LT_OPACITY_MEAN,        /* of the views; 0 where one sees the place with nothing before it     [HOGS, Eq. 16] */
    LT_OPACITY_MIN,         /* of the views                                                        [GOF, Eq. 14] */
    LT_OPACITY_RULES,
} lt_opacity_rule;

/* lt_opacity_rule_name - "mean", "min" */
LT_API const char *lt_opacity_rule_name(lt_opacity_rule rule);

enum { LT_OPACITY_VIEWS = 16 };

/* Read-only once made: any number of threads may ask. */
typedef struct lt_opacity_field lt_opacity_field;

/**
 * lt_opacity_field_new - of n Gaussians, in arena memory; they are copied
 *
 * Sixteen views lie on a sphere around the middle of the Gaussians' box, along Fibonacci's spiral, at 2.4 times the
 * radius that has all boxes of three deviations in it. On the ray from a view to a place a Gaussian's alpha is opacity
 * exp(-d^2 / 2), d being the least distance, in deviations, that the ray has from its centre up to the place: 0.99 at
 * most, and nothing below 1/255.
 *
 * Errors: LT_EINVAL: no Gaussian, a number that is not finite, an opacity outside of 0 .. 1; LT_ENOMEM.
 *
 * Source: HOGS, Appendix A; Yu et al. 2024, "Gaussian opacity fields", section 4.
 */
LT_API lt_status lt_opacity_field_new(lt_arena *arena, int64_t n, const lt_gaussian *g, lt_opacity_field **out);

/**
 * lt_opacity_at - the field at n places, to opacity (n), 0 .. 1
 *
 * A view's opacity is the sum of each alpha times what those before it leave, which is one less the product of what
 * they leave: so their order does not matter. Away from all Gaussians it is 0, and so it is where a place is not
 * finite. Uses all threads, and has the same bits on any number of them. Errors: LT_ENOMEM.
 */
LT_API lt_status lt_opacity_at(const lt_opacity_field *f, lt_opacity_rule rule, int64_t n, const double (*place)[3],
                               double *opacity);

/**
 * lt_opacity_mesh - the surface at which the field crosses iso, in arena memory
 *
 *   color    (n, 3) of the Gaussians, in any space: a vertex has that of the nearest one. NULL: none
 *   iso      between 0 and 1: HOGS takes 0.6, GOF 0.5
 *
 * Delaunay tetrahedra of the centres and of the corners of their boxes of three deviations, of Gaussians of opacity
 * 0.05 and more, places within a micrometre being one; the field at their points; where it crosses along an edge by
 * eight bisections. Parts of less than a hundredth of the area are left out. Always closed: beyond the points there is
 * nothing. Faces are counter-clockwise seen from outside.
 *
 * Errors: those of lt_opacity_field_new; LT_EINVAL for another iso, for points in one plane, and where nothing is as
 * opaque as iso.
 */
LT_API lt_status lt_opacity_mesh(lt_arena *arena, int64_t n, const lt_gaussian *g, const float (*color)[3],
                                 lt_opacity_rule rule, double iso, lt_mesh *out);

#ifdef __cplusplus
}
#endif
#endif
