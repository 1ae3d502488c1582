/* SPDX-License-Identifier: Apache-2.0 */
/* The lens of OpenCV's calib3d.                                          [Brown 1966; OpenCV documentation, calib3d] */
#include "libtensor/geometry/lens.h"

#include <math.h>
#include <string.h>

enum { STEPS = 256, ITERATIONS = 50 };
static const double CLOSE = 1e-10;              /* of depth 1: far less than a pixel */

lt_status lt_lens_from_opencv(const double *c, int n, lt_lens *out)
{
    if (n != 4 && n != 5 && n != 8 && n != 12 && n != 14)
        return lt_error(LT_EINVAL, "%d coefficients of a lens, want 4, 5 or 8: k1,k2,p1,p2[,k3[,k4,k5,k6]]", n);
    for (int i = 0; i < n; i++)
        if (!isfinite(c[i]))
            return lt_error(LT_EINVAL, "coefficient %d of a lens is not finite", i + 1);
    for (int i = LT_LENS_COEFFICIENTS; i < n; i++)
        if (c[i] != 0)
            return lt_error(LT_EINVAL, "coefficient %d of a lens is %g, want 0: thin prisms and tilted sensors are not "
                            "known", i + 1, c[i]);
    *out = (lt_lens){ .k = { c[0], c[1], n > 4 ? c[4] : 0, n > 5 ? c[5] : 0, n > 5 ? c[6] : 0, n > 5 ? c[7] : 0 },
                      .p = { c[2], c[3] } };
    return LT_OK;
}

void lt_lens_to_opencv(const lt_lens *l, double c[LT_LENS_COEFFICIENTS])
{
    memcpy(c, l->k, 2 * sizeof(*c));
    memcpy(c + 2, l->p, 2 * sizeof(*c));
    memcpy(c + 4, l->k + 2, 4 * sizeof(*c));
}

bool lt_lens_is_none(const lt_lens *l)
{
    bool any = l->p[0] != 0 || l->p[1] != 0;

    for (int i = 0; i < 6; i++)
        any = any || l->k[i] != 0;
    return !any;
}

/* (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6) */
static double radial(const lt_lens *l, double r2)
{
    return (1 + r2 * (l->k[0] + r2 * (l->k[1] + r2 * l->k[2]))) / (1 + r2 * (l->k[3] + r2 * (l->k[4] + r2 * l->k[5])));
}

/* What the tangential part adds */
static void tangential(const lt_lens *l, double x, double y, double add[2])
{
    const double r2 = x * x + y * y;

    add[0] = 2 * l->p[0] * x * y + l->p[1] * (r2 + 2 * x * x);
    add[1] = l->p[0] * (r2 + 2 * y * y) + 2 * l->p[1] * x * y;
}

void lt_lens_distort(const lt_lens *l, const double x[2], double out[2])
{
    const double f = radial(l, x[0] * x[0] + x[1] * x[1]);
    double add[2];

    tangential(l, x[0], x[1], add);
    out[0] = x[0] * f + add[0];
    out[1] = x[1] * f + add[1];
}

/* A fixed point of x = (seen - tangential(x)) / radial(x), as OpenCV looks for it. */
bool lt_lens_undistort(const lt_lens *l, const double seen[2], double out[2])
{
    double x[2] = { seen[0], seen[1] };

    for (int i = 0; i < ITERATIONS; i++) {
        const double f = radial(l, x[0] * x[0] + x[1] * x[1]);
        double add[2], back[2];

        tangential(l, x[0], x[1], add);
        x[0] = (seen[0] - add[0]) / f;
        x[1] = (seen[1] - add[1]) / f;
        lt_lens_distort(l, x, back);
        if (fabs(back[0] - seen[0]) < CLOSE && fabs(back[1] - seen[1]) < CLOSE) {
            out[0] = x[0];
            out[1] = x[1];
            return true;
        }
    }
    out[0] = seen[0];
    out[1] = seen[1];
    return false;
}

double lt_lens_fold(const lt_lens *l, double farthest)
{
    double before = 0;

    for (int i = 1; i <= STEPS; i++) {
        const double r = farthest * i / STEPS, seen = r * radial(l, r * r);

        if (!(seen > before))
            return farthest * (i - 1) / STEPS;
        before = seen;
    }
    return INFINITY;
}
