/* SPDX-License-Identifier: Apache-2.0 */
#include "assets/ycb/loft.h"

#include "libtensor/geometry/mat3.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { MAX_COLUMNS = 96, ARC = 3 };         /* ARC: steps round a rectangle's corner */

#define SEAM 0.2                            /* in the units of the build, millimetres */

typedef struct { double x, y; } point;

lt_status loft_builder_init(loft_builder *b, lt_arena *arena, int max_vertices)
{
    const size_t n = (size_t)max_vertices;

    *b = (loft_builder){ .max_vertices = max_vertices, .max_faces = 2 * max_vertices, .ok = true };
    b->mesh.vertex = lt_arena_array(arena, n, sizeof(*b->mesh.vertex));
    b->mesh.uv = lt_arena_array(arena, n, sizeof(*b->mesh.uv));
    b->mesh.face = lt_arena_array(arena, 2 * n, sizeof(*b->mesh.face));
    if (!b->mesh.vertex || !b->mesh.uv || !b->mesh.face)
        return lt_error(LT_ENOMEM, "no memory for a mesh of %d vertices", max_vertices);
    return LT_OK;
}

static point superellipse(const loft_section *s, double t)
{
    const double c = cos(2 * M_PI * t), d = sin(2 * M_PI * t), e = 2 / s->power;

    return (point){ s->a * copysign(pow(fabs(c), e), c), s->b * copysign(pow(fabs(d), e), d) };
}

/* Quarter q starts in the corner between sides q - 1 and q; side 0 faces +x. */
static point rounded_rectangle(const loft_section *s, int i, int columns)
{
    const int per = columns / 4, q = i / per, k = i % per;
    const double r = fmin(s->corner, 0.8 * fmin(s->a, s->b));
    const double w = s->a - r, h = s->b - r;
    const double corner[5][2] = { { w, -h }, { w, h }, { -w, h }, { -w, -h }, { w, -h } };
    const double angle = M_PI / 2 * (q - 1 + (double)(k < ARC ? k : ARC) / ARC);
    const double f = k > ARC ? (double)(k - ARC) / (per - ARC) : 0;
    const double *from = corner[q], *to = corner[q + 1];

    return (point){ from[0] + f * (to[0] - from[0]) + r * cos(angle),
                    from[1] + f * (to[1] - from[1]) + r * sin(angle) };
}

static point bulged(const loft_section *s, point p)
{
    const double u = p.x / s->a, v = p.y / s->b;

    return (point){ p.x + s->bulge * u * fmax(0, 1 - v * v), p.y + s->bulge * v * fmax(0, 1 - u * u) };
}

/* columns + 1 points: the last stands SEAM before the first and ends the texture. */
static void outline(const loft_section *s, int columns, point *p)
{
    double back, f;

    for (int i = 0; i < columns; i++)
        p[i] = bulged(s, s->corner < 0 ? superellipse(s, (double)i / columns)
                                       : rounded_rectangle(s, i, columns));
    back = hypot(p[columns - 1].x - p[0].x, p[columns - 1].y - p[0].y);
    f = fmin(0.1, SEAM / back);
    p[columns].x = p[0].x + f * (p[columns - 1].x - p[0].x);
    p[columns].y = p[0].y + f * (p[columns - 1].y - p[0].y);
}

static int add_vertex(loft_builder *b, const loft_section *s, point p, double u, double v)
{
    lt_mesh *m = &b->mesh;
    const int i = m->n_vertices;

    if (i >= b->max_vertices) {
        b->ok = false;
        return 0;
    }
    for (int k = 0; k < 3; k++)
        m->vertex[i][k] = (float)(s->centre[k] + p.x * s->x[k] + p.y * s->y[k]);
    m->uv[i][0] = (float)u;
    m->uv[i][1] = (float)v;
    return m->n_vertices++;
}

static void add_face(loft_builder *b, int i, int j, int k)
{
    lt_mesh *m = &b->mesh;

    if (m->n_faces >= b->max_faces) {
        b->ok = false;
        return;
    }
    m->face[m->n_faces][0] = i;
    m->face[m->n_faces][1] = j;
    m->face[m->n_faces][2] = k;
    m->n_faces++;
}

static void flat_uv(const loft_chart *c, point p, double uv[2])
{
    const double x = fmax(-1, fmin(1, p.x / c->half)), y = fmax(-1, fmin(1, p.y / c->half));

    uv[0] = c->u0 + (c->u1 - c->u0) * (x + 1) / 2;
    uv[1] = c->v0 + (c->v1 - c->v0) * (y + 1) / 2;
}

/* One section's ring of columns + 1 vertices; `along` in 0..1 is how far it is through its chart. */
static int add_ring(loft_builder *b, const loft_section *s, int columns, double along)
{
    point p[MAX_COLUMNS + 1];
    double round[MAX_COLUMNS + 1] = { 0 }, uv[2];
    const int first = b->mesh.n_vertices;

    outline(s, columns, p);
    for (int i = 0; i < columns; i++)
        round[i + 1] = round[i] + hypot(p[i + 1].x - p[i].x, p[i + 1].y - p[i].y);
    for (int i = 0; i <= columns; i++) {
        uv[0] = s->chart->u0 + (s->chart->u1 - s->chart->u0) * round[i] / round[columns];
        uv[1] = s->chart->v0 + (s->chart->v1 - s->chart->v0) * along;
        if (s->chart->flat)
            flat_uv(s->chart, p[i], uv);
        add_vertex(b, s, p[i], uv[0], uv[1]);
    }
    return first;
}

static int add_pole(loft_builder *b, const loft_section *s, double along)
{
    const loft_chart *c = s->chart;
    double uv[2] = { (c->u0 + c->u1) / 2, c->v0 + (c->v1 - c->v0) * along };

    if (c->flat)
        flat_uv(c, (point){ 0, 0 }, uv);
    return add_vertex(b, s, (point){ 0, 0 }, uv[0], uv[1]);
}

static void join_rings(loft_builder *b, int low, int high, int columns)
{
    const int n = columns + 1;

    for (int i = 0; i < n; i++) {
        const int j = (i + 1) % n;
        add_face(b, low + i, low + j, high + j);
        add_face(b, low + i, high + j, high + i);
    }
}

static void join_pole(loft_builder *b, int pole, int ring, int columns, bool at_end)
{
    const int n = columns + 1;

    for (int i = 0; i < n; i++) {
        const int j = (i + 1) % n;
        add_face(b, pole, ring + (at_end ? i : j), ring + (at_end ? j : i));
    }
}

/* Mean distance of two outlines, for an even texture along the loft. */
static double step_length(const loft_section *s, const loft_section *t)
{
    double d2 = 0;

    for (int side = 0; side < 4; side++) {
        const double f = side < 2 ? 1 : -1;
        double sum = 0;
        for (int k = 0; k < 3; k++) {
            const double d = side % 2 ? t->centre[k] + f * t->b * t->y[k] - s->centre[k] - f * s->b * s->y[k]
                                      : t->centre[k] + f * t->a * t->x[k] - s->centre[k] - f * s->a * s->x[k];
            sum += d * d;
        }
        d2 += sqrt(sum) / 4;
    }
    return d2;
}

/* along[i]: the way from the first section of i's chart, as a share of that chart's whole way. */
static void chart_progress(const loft *l, double *along)
{
    double whole;

    for (int i = 0, j; i < l->n; i = j) {
        along[i] = 0;
        for (j = i + 1; j < l->n && l->section[j].chart == l->section[i].chart; j++)
            along[j] = along[j - 1] + step_length(&l->section[j - 1], &l->section[j]);
        whole = along[j - 1];
        for (int k = i + 1; k < j; k++)
            along[k] /= whole;
    }
}

void loft_build(loft_builder *b, const loft *l)
{
    double along[LOFT_SECTIONS];
    int first = 0, ring = 0, next;

    assert(l->columns <= MAX_COLUMNS && l->columns % 4 == 0 && l->columns / 4 > ARC && l->n > 1);
    chart_progress(l, along);
    for (int i = 0; i < l->n; i++) {
        next = add_ring(b, &l->section[i], l->columns, along[i]);
        if (i == 0)
            first = next;
        else
            join_rings(b, ring, next, l->columns);
        ring = next;
    }
    if (l->closed) {
        join_rings(b, ring, first, l->columns);
        return;
    }
    join_pole(b, add_pole(b, &l->section[0], along[0]), first, l->columns, false);
    join_pole(b, add_pole(b, &l->section[l->n - 1], along[l->n - 1]), ring, l->columns, true);
}

/* The copy is moved by SEAM towards s, so that the strip between has an area. */
void loft_push(loft *l, const loft_section *s)
{
    loft_section *last = l->n ? &l->section[l->n - 1] : NULL;

    assert(l->n + 2 <= LOFT_SECTIONS);
    if (last && last->chart != s->chart) {
        const double f = fmin(0.1, SEAM / fmax(SEAM, step_length(last, s)));
        loft_section copy = *last;
        copy.chart = s->chart;
        copy.a += f * (s->a - last->a);
        copy.b += f * (s->b - last->b);
        for (int k = 0; k < 3; k++)
            copy.centre[k] += f * (s->centre[k] - last->centre[k]);
        l->section[l->n++] = copy;
    }
    l->section[l->n++] = *s;
}

loft_section loft_level(double cx, double cy, double z, double a, double b, const loft_chart *chart)
{
    return (loft_section){ .centre = { cx, cy, z }, .x = { 1, 0, 0 }, .y = { 0, 1, 0 },
                           .a = a, .b = b, .corner = -1, .power = 2, .chart = chart };
}

loft_section loft_across(const double centre[3], const double along[3], const double up[3],
                         double a, double b, const loft_chart *chart)
{
    loft_section s = loft_level(centre[0], centre[1], centre[2], a, b, chart);
    double t[3] = { along[0], along[1], along[2] }, lift;

    lt_vec3_unit(t);
    lift = lt_vec3_dot(up, t);
    for (int k = 0; k < 3; k++)
        s.y[k] = up[k] - lift * t[k];
    lt_vec3_unit(s.y);
    lt_vec3_cross(s.y, t, s.x);
    return s;
}
