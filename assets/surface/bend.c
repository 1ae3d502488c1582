/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What linear blend skinning loses at a bent joint, put back before skinning.
 *
 * Skin that follows a joint bent by t with share w lands at ((1 - w) + w e^it) r around the axis, where it
 * should land at e^iwt r: round the back of the joint it caves in by up to a third. The missing factor
 *     g(t) = e^iwt / ((1 - w) + w e^it) - 1   is fitted by   a sin t + b (1 - cos t)
 * with complex a, b. As sin t = <N, R - I> / 2 and 1 - cos t = <NN, R - I> / 2 for R the turn by t about the
 * axis n, N = [n]x, that is linear in R - I, as posedirs must be.
 */
#include "assets/surface/surface.h"

#include <complex.h>

typedef struct { double complex a, b; } bend_fit;

/* Least squares over the bends that a finger makes. */
static bend_fit fit_bend(double w)
{
    static const double deg[] = { -20, 15, 30, 45, 60, 75, 90 };
    double ss = 0, sc = 0, cc = 0;
    double complex sg = 0, cg = 0;

    for (size_t i = 0; i < LT_COUNT(deg); i++) {
        const double t = deg[i] * M_PI / 180, si = sin(t), co = 1 - cos(t);
        const double complex g = cexp(I * w * t) / (1 - w + w * cexp(I * t)) - 1;

        ss += si * si;
        sc += si * co;
        cc += co * co;
        sg += si * g;
        cg += co * g;
    }
    const double det = ss * cc - sc * sc;
    return (bend_fit){ (sg * cc - cg * sc) / det, (cg * ss - sg * sc) / det };
}

static void add_feature(float *dirs, int features, int at, vec3 d, double factor)
{
    dirs[at] += (float)(factor * d.x / 1000);
    dirs[features + at] += (float)(factor * d.y / 1000);
    dirs[2 * features + at] += (float)(factor * d.z / 1000);
}

/* out += sin_dir sin t + cos_dir (1 - cos t), written on the nine entries of R - I */
static void add_bend(float *dirs, int features, int first, vec3 n, vec3 sin_dir, vec3 cos_dir)
{
    const double skew[9] = { 0, -n.z, n.y, n.z, 0, -n.x, -n.y, n.x, 0 };
    const double axis[3] = { n.x, n.y, n.z };

    for (int e = 0; e < 9; e++) {
        add_feature(dirs, features, first + e, sin_dir, skew[e] / 2);
        add_feature(dirs, features, first + e, cos_dir, (axis[e / 3] * axis[e % 3] - (e % 4 == 0)) / 2);
    }
}

void surface_bend(const surface_hinge *h, vec3 from_joint, double share, float *dirs, int features)
{
    const vec3 n = h->axis, r = reject(from_joint, n), turned = cross(n, r);
    const bend_fit f = fit_bend(share);

    add_bend(dirs, features, 9 * (h->joint - 1), n,
             scale(madd(scale(r, creal(f.a)), turned, cimag(f.a)), h->gain),
             add(scale(madd(scale(r, creal(f.b)), turned, cimag(f.b)), h->gain), h->puff));
}
