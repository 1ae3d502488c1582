/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/ycb/solid.h"

#include <math.h>

const loft_chart synth_charts[CHART_COUNT] = {
    [CHART_SIDE] = { .u0 = 0, .v0 = 0.34, .u1 = 1, .v1 = 1 },
    [CHART_TOP] = { .flat = true, .u0 = 0.02, .v0 = 0.02, .u1 = 0.31, .v1 = 0.31 },
    [CHART_BOTTOM] = { .flat = true, .u0 = 0.35, .v0 = 0.02, .u1 = 0.64, .v1 = 0.31 },
    [CHART_SECOND] = { .u0 = 0.69, .v0 = 0.19, .u1 = 0.98, .v1 = 0.31 },
    [CHART_THIRD] = { .u0 = 0.69, .v0 = 0.02, .u1 = 0.98, .v1 = 0.14 },
};

static loft_section section_at(const solid_cut *c, const solid_level *l, const loft_chart *charts)
{
    const double t = c->bulge_height > 0 ? l->z / c->bulge_height : 1;
    loft_section s = {
        .a = l->a, .b = l->b, .corner = c->corner, .power = l->power > 0 ? l->power : 2,
        .bulge = c->bulge * fmax(0, 1 - t * t), .chart = &charts[l->chart],
    };

    for (int k = 0; k < 3; k++) {
        s.centre[k] = c->origin[k] + l->cx * c->x[k] + l->z * c->z[k];
        s.x[k] = c->x[k];
        s.y[k] = c->y[k];
    }
    return s;
}

static solid_level between(const solid_level *p, const solid_level *q, double f)
{
    const double pp = p->power > 0 ? p->power : 2, qp = q->power > 0 ? q->power : 2;

    return (solid_level){ q->chart, p->z + f * (q->z - p->z), p->a + f * (q->a - p->a), p->b + f * (q->b - p->b),
                    p->cx + f * (q->cx - p->cx), pp + f * (qp - pp) };
}

/* A flat chart is laid out to the largest outline that uses it. */
static void size_charts(loft_chart *charts, const solid_level *l, int n)
{
    for (int i = 0; i < CHART_COUNT; i++)
        charts[i] = synth_charts[i];
    for (int i = 0; i < n; i++)
        charts[l[i].chart].half = fmax(charts[l[i].chart].half, fmax(l[i].a, l[i].b));
}

void solid_build(loft_builder *b, const solid_cut *c, const solid_level *l, int n)
{
    loft_chart charts[CHART_COUNT];
    loft body = { .columns = c->columns };

    size_charts(charts, l, n);
    for (int i = 0; i < n; i++) {
        const double way = i ? hypot(l[i].z - l[i - 1].z, l[i].a - l[i - 1].a) : 0;
        const int parts = i ? (int)fmax(1, ceil(way / c->step)) : 1;
        for (int k = 1; k <= parts; k++) {
            const solid_level here = i ? between(&l[i - 1], &l[i], (double)k / parts) : l[i];
            const loft_section s = section_at(c, &here, charts);
            loft_push(&body, &s);
        }
    }
    loft_build(b, &body);
}

static double spline(double p0, double p1, double p2, double p3, double t)
{
    return 0.5 * (2 * p1 + t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3
                                               + t * (3 * (p1 - p2) + p3 - p0))));
}

/* Catmull-Rom through the knots; t in knots. */
static sweep_knot path_at(const sweep_knot *k, int n, bool closed, double t)
{
    const int i = (int)fmin(floor(t), closed ? n - 1 : n - 2);
    const double f = t - i;
    const sweep_knot *p[4];

    for (int j = 0; j < 4; j++)
        p[j] = &k[closed ? (i + j - 1 + n) % n : (int)fmax(0, fmin(n - 1, i + j - 1))];
    return (sweep_knot){
        spline(p[0]->x, p[1]->x, p[2]->x, p[3]->x, f), spline(p[0]->y, p[1]->y, p[2]->y, p[3]->y, f),
        spline(p[0]->z, p[1]->z, p[2]->z, p[3]->z, f), spline(p[0]->a, p[1]->a, p[2]->a, p[3]->a, f),
        spline(p[0]->b, p[1]->b, p[2]->b, p[3]->b, f),
    };
}

void sweep_build(loft_builder *b, const sweep_pipe *s, const sweep_knot *k, int n)
{
    loft body = { .columns = s->columns, .closed = s->closed };
    const double span = s->closed ? n : n - 1, h = 1e-3;

    for (int i = 0; i < s->rings; i++) {
        const double t = span * i / (s->closed ? s->rings : s->rings - 1);
        const sweep_knot at = path_at(k, n, s->closed, t);
        const sweep_knot p = path_at(k, n, s->closed, s->closed || t > h ? fmax(0, t - h) : t);
        const sweep_knot q = path_at(k, n, s->closed, fmin(span, t + h));
        const double centre[3] = { at.x, at.y, at.z }, along[3] = { q.x - p.x, q.y - p.y, q.z - p.z };
        loft_section ring = loft_across(centre, along, s->up, at.a, at.b, &synth_charts[s->chart]);
        ring.power = s->power > 0 ? s->power : 2;
        loft_push(&body, &ring);
    }
    loft_build(b, &body);
}
