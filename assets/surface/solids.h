/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Signed distances to simple solids, of which skins are put together.
 *
 * Source: Quilez, "Distance functions" and "Smooth minimum" (iquilezles.org).
 */
#ifndef ASSETS_SURFACE_SOLIDS_H
#define ASSETS_SURFACE_SOLIDS_H

#include "assets/surface/vec3.h"

/* The smaller of a and b, with a fillet where they differ by less than k. */
static inline double smooth_min(double a, double b, double k)
{
    const double h = fmax(k - fabs(a - b), 0) / k;
    return fmin(a, b) - h * h * k / 4;
}

/* A cone from a (radius ra) to b (radius rb) with round ends. */
static inline double round_cone(vec3 p, vec3 a, vec3 b, double ra, double rb)
{
    const vec3 ba = sub(b, a), pa = sub(p, a);
    const double l2 = dot(ba, ba), rr = ra - rb, a2 = l2 - rr * rr;
    const double y = dot(pa, ba), z = y - l2;
    const vec3 off = sub(scale(pa, l2), scale(ba, y));
    const double x2 = dot(off, off), y2 = y * y * l2, z2 = z * z * l2;
    const double k = copysign(rr * rr * x2, rr);

    if (copysign(a2 * z2, z) > k)
        return sqrt(x2 + z2) / l2 - rb;
    if (copysign(a2 * y2, y) < k)
        return sqrt(x2 + y2) / l2 - ra;
    return (sqrt(x2 * a2 / l2) + y * rr) / l2 - ra;
}

/* An ellipsoid with its first axis along u, its second as near to v as can be; good near its surface. */
static inline double ellipsoid(vec3 p, vec3 center, vec3 u, vec3 v, vec3 radii)
{
    const vec3 ex = unit(u), ey = unit(reject(v, ex)), ez = cross(ex, ey), q = sub(p, center);
    const vec3 a = vec(dot(q, ex) / radii.x, dot(q, ey) / radii.y, dot(q, ez) / radii.z);
    const vec3 b = vec(a.x / radii.x, a.y / radii.y, a.z / radii.z);
    const double na = norm(a), nb = norm(b);

    return nb > 0 ? na * (na - 1) / nb : -fmin(radii.x, fmin(radii.y, radii.z));
}

#endif
