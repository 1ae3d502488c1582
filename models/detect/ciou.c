/* SPDX-License-Identifier: Apache-2.0 */
#include "models/detect/ciou.h"

#include <math.h>
#include <stdbool.h>

static const double TINY = 1e-7;        /* keeps boxes without area out of divisions */
static const double SHAPE = 4 / (3.14159265358979323846 * 3.14159265358979323846);

enum { X0, Y0, X1, Y1 };

/* What a pair of boxes has in common; d: of a's sides x0 y0 x1 y1 */
typedef struct { double value, d[4]; } sloped;

/* Length of what both cover along an axis, and of what covers both; lo: X0 or Y0 */
static sloped shared(const ciou_box *a, const ciou_box *b, int lo)
{
    const int hi = lo + 2;
    sloped s = { fmin(a->v[hi], b->v[hi]) - fmax(a->v[lo], b->v[lo]), { 0 } };

    if (s.value <= 0)
        return (sloped){ 0, { 0 } };
    s.d[hi] = a->v[hi] < b->v[hi];
    s.d[lo] = -(a->v[lo] > b->v[lo]);
    return s;
}

static sloped hull(const ciou_box *a, const ciou_box *b, int lo)
{
    const int hi = lo + 2;
    sloped s = { fmax(a->v[hi], b->v[hi]) - fmin(a->v[lo], b->v[lo]), { 0 } };

    s.d[hi] = a->v[hi] > b->v[hi];
    s.d[lo] = -(a->v[lo] < b->v[lo]);
    return s;
}

static sloped overlap(const ciou_box *a, const ciou_box *b)
{
    const sloped w = shared(a, b, X0), h = shared(a, b, Y0);
    const double aw = a->v[X1] - a->v[X0], ah = a->v[Y1] - a->v[Y0] + TINY;
    const double bw = b->v[X1] - b->v[X0], bh = b->v[Y1] - b->v[Y0] + TINY;
    const double in = w.value * h.value, all = aw * ah + bw * bh - in + TINY;
    const double area[4] = { -ah, -aw, ah, aw };
    sloped out = { in / all, { 0 } };

    for (int i = 0; i < 4; i++) {
        const double din = w.d[i] * h.value + w.value * h.d[i];

        out.d[i] = din / all - in * (area[i] - din) / (all * all);
    }
    return out;
}

/* The square of the centres' distance, of the hull's diagonal's */
static sloped distance(const ciou_box *a, const ciou_box *b)
{
    const sloped w = hull(a, b, X0), h = hull(a, b, Y0);
    const double dx = (b->v[X0] + b->v[X1] - a->v[X0] - a->v[X1]) / 2;
    const double dy = (b->v[Y0] + b->v[Y1] - a->v[Y0] - a->v[Y1]) / 2;
    const double c = w.value * w.value + h.value * h.value + TINY, rho = dx * dx + dy * dy;
    const double drho[4] = { -dx, -dy, -dx, -dy };
    sloped out = { rho / c, { 0 } };

    for (int i = 0; i < 4; i++)
        out.d[i] = drho[i] / c - rho * 2 * (w.value * w.d[i] + h.value * h.d[i]) / (c * c);
    return out;
}

/* v, equation 9 */
static sloped shape(const ciou_box *a, const ciou_box *b)
{
    const double w = a->v[X1] - a->v[X0], h = a->v[Y1] - a->v[Y0] + TINY;
    const double angle = atan((b->v[X1] - b->v[X0]) / (b->v[Y1] - b->v[Y0] + TINY)) - atan(w / h);
    const double dw = -2 * SHAPE * angle * h / (w * w + h * h), dh = 2 * SHAPE * angle * w / (w * w + h * h);

    return (sloped){ SHAPE * angle * angle, { -dw, -dh, dw, dh } };
}

double ciou_with(const ciou_box *a, const ciou_box *b, double alpha, double *grad)
{
    const sloped iou = overlap(a, b), far = distance(a, b), v = shape(a, b);

    for (int i = 0; grad && i < 4; i++)
        grad[i] = iou.d[i] - far.d[i] - alpha * v.d[i];
    return iou.value - far.value - alpha * v.value;
}

double ciou(const ciou_box *a, const ciou_box *b, double *alpha)
{
    const double iou = overlap(a, b).value, v = shape(a, b).value, weight = v / (v - iou + 1 + TINY);

    if (alpha)
        *alpha = weight;
    return ciou_with(a, b, weight, 0);
}
