/* SPDX-License-Identifier: Apache-2.0 */
/* The translation that puts points where they are seen: 3 x 3 normal equations, eliminated by hand. */
#include "libtensor/geometry/translation.h"

#include <math.h>
#include <string.h>

static const double MIN_VARIANCE_PX2 = 1e-6;

/* The normal equations [a 0 p; 0 b q; p q r] t = (x, y, z); w is the sum of the weights. */
typedef struct { double a, b, p, q, r, x, y, z, w; } normal;

static double weight_of(const double *weight, int i)
{
    return weight ? weight[i] : 1;
}

static lt_status check(const lt_camera *cam, int n, int least, const double *X, const double *uv, const double *weight)
{
    double sum = cam->cx + cam->cy;

    if (n < least)
        return lt_error(LT_EINVAL, "hand translation: %d points, want %d or more", n, least);
    if (!(cam->fx > 0 && cam->fy > 0 && isfinite(cam->fx) && isfinite(cam->fy)))
        return lt_error(LT_EINVAL, "hand translation: focal lengths are %g and %g, want them positive",
                        cam->fx, cam->fy);
    for (int i = 0; i < n; i++) {
        if (!(weight_of(weight, i) >= 0))
            return lt_error(LT_EINVAL, "hand translation: weight %d is %g", i, weight[i]);
        sum += X[3 * i] + X[3 * i + 1] + X[3 * i + 2] + uv[2 * i] + uv[2 * i + 1] + weight_of(weight, i);
    }
    if (!isfinite(sum))
        return lt_error(LT_EINVAL, "hand translation: a coordinate is not finite");
    return LT_OK;
}

/* Rows of point i: (fx, 0, -du) t = du Z - fx X and (0, fy, -dv) t = dv Z - fy Y. */
static void add_point(normal *s, const lt_camera *cam, const double X[3], const double uv[2], double w)
{
    const double du = uv[0] - cam->cx, dv = uv[1] - cam->cy;
    const double ex = du * X[2] - cam->fx * X[0], ey = dv * X[2] - cam->fy * X[1];

    s->a += w * cam->fx * cam->fx;
    s->b += w * cam->fy * cam->fy;
    s->p -= w * cam->fx * du;
    s->q -= w * cam->fy * dv;
    s->r += w * (du * du + dv * dv);
    s->x += w * cam->fx * ex;
    s->y += w * cam->fy * ey;
    s->z -= w * (du * ex + dv * ey);
    s->w += w;
}

static normal sum_up(const lt_camera *cam, int n, const double *X, const double *uv, const double *weight)
{
    normal s = { 0 };

    for (int i = 0; i < n; i++)
        add_point(&s, cam, X + 3 * i, uv + 2 * i, weight_of(weight, i));
    return s;
}

static void solve_across(const normal *s, double t[3])
{
    t[0] = (s->x - s->p * t[2]) / s->a;
    t[1] = (s->y - s->q * t[2]) / s->b;
}

static lt_status solve(const normal *s, double t[3])
{
    const double spread = s->r - s->p * s->p / s->a - s->q * s->q / s->b;    /* of uv, times w */

    if (!(s->w > 0 && spread > MIN_VARIANCE_PX2 * s->w))
        return lt_error(LT_ENUMERIC, "hand translation: the points are seen in one place, so their depth "
                        "is unknown");
    t[2] = (s->z - s->p * s->x / s->a - s->q * s->y / s->b) / spread;
    solve_across(s, t);
    return LT_OK;
}

static lt_status check_in_front(int n, const double *X, const double *weight, const double t[3])
{
    for (int i = 0; i < n; i++)
        if (weight_of(weight, i) > 0 && !(X[3 * i + 2] + t[2] > 0))
            return lt_error(LT_ENUMERIC, "hand translation: point %d would stand %.3g m behind the camera",
                            i, -(X[3 * i + 2] + t[2]));
    return LT_OK;
}

lt_status lt_hand_translation(const lt_camera *cam, int n, const double *X, const double *uv,
                              const double *weight, double t[3])
{
    double found[3] = { 0 };
    lt_status st = check(cam, n, 2, X, uv, weight);
    normal s;

    if (st)
        return st;
    s = sum_up(cam, n, X, uv, weight);
    st = solve(&s, found);
    st = st ? st : check_in_front(n, X, weight, found);
    if (st)
        return st;
    memcpy(t, found, sizeof(found));
    return LT_OK;
}

lt_status lt_hand_translation_at(const lt_camera *cam, int n, const double *X, const double *uv,
                                 const double *weight, double depth, double t[3])
{
    double found[3] = { 0, 0, depth };
    lt_status st = check(cam, n, 1, X, uv, weight);
    normal s;

    st = st ? st : check_in_front(n, X, weight, found);
    if (st)
        return st;
    s = sum_up(cam, n, X, uv, weight);
    if (!(s.w > 0))
        return lt_error(LT_ENUMERIC, "hand translation: no point has weight");
    solve_across(&s, found);
    memcpy(t, found, sizeof(found));
    return LT_OK;
}
