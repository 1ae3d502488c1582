/* SPDX-License-Identifier: Apache-2.0 */
/* Fills the triangles of a posed mesh, row by row. */
#include "vision/silhouette.h"

#include <math.h>
#include <string.h>

static const double NEAR = 0.01;            /* metres */

typedef struct { double u, v, z; } spot;

static spot project(const float *x, const float *R, const float *t, const lt_camera *cam)
{
    double p[3], uv[2];

    for (int i = 0; i < 3; i++)
        p[i] = (double)R[3 * i] * x[0] + (double)R[3 * i + 1] * x[1] + (double)R[3 * i + 2] * x[2] + t[i];
    lt_camera_project(cam, p, uv);
    return (spot){ uv[0], uv[1], p[2] };
}

/* Without libm's calls: they were half of the time, for models have thousands of small faces. */
static double less(double a, double b) { return a < b ? a : b; }
static double greater(double a, double b) { return a > b ? a : b; }

/* The first whole number from x on, and the last up to x, for x of a picture's size, 0 or more. */
static int first_from(double x) { return (int)x + (x > (int)x); }
static int last_to(double x) { return (int)x; }

/* Where the edge a-b crosses row y widens [*lo, *hi]. */
static inline void cross_edge(const spot *a, const spot *b, double y, double *lo, double *hi)
{
    double x;

    if ((a->v <= y) == (b->v <= y))
        return;
    x = a->u + (y - a->v) / (b->v - a->v) * (b->u - a->u);
    *lo = less(*lo, x);
    *hi = greater(*hi, x);
}

/* 1 / z over a triangle is a plane in the image. */
typedef struct { double u, v, at, du, dv, lo, hi; } inverse_depth;

static inverse_depth inverse_depth_of(const spot *a, const spot *b, const spot *c)
{
    const double p = 1 / a->z, q = 1 / b->z - p, r = 1 / c->z - p;
    const double bu = b->u - a->u, bv = b->v - a->v, cu = c->u - a->u, cv = c->v - a->v, det = bu * cv - cu * bv;
    inverse_depth d = { a->u, a->v, p, 0, 0, p + less(0, less(q, r)), p + greater(0, greater(q, r)) };

    if (det != 0) {
        d.du = (q * cv - r * bv) / det;
        d.dv = (r * bu - q * cu) / det;
    }
    return d;
}

/* Where a mesh is drawn: mask or depth, the other NULL */
typedef struct { uint8_t *mask; float *depth; int width, height; } canvas;

/* Pixels [x0, x1] of row y */
static void put_span(const canvas *out, const inverse_depth *d, int y, int x0, int x1)
{
    const size_t row = (size_t)y * (size_t)out->width;

    for (int x = x0; x <= x1 && out->mask; x++)
        out->mask[row + (size_t)x] = 1;
    for (int x = x0; x <= x1 && out->depth; x++) {
        const double q = d->at + d->du * (x - d->u) + d->dv * (y - d->v);
        const float here = (float)(1 / less(d->hi, greater(d->lo, q)));
        float *z = &out->depth[row + (size_t)x];

        *z = *z == 0 || here < *z ? here : *z;
    }
}

static void fill(const spot *a, const spot *b, const spot *c, const canvas *out)
{
    const double top = less(a->v, less(b->v, c->v)), bottom = greater(a->v, greater(b->v, c->v));
    const int width = out->width, height = out->height;
    inverse_depth d = { 0 };

    if (!(top < height && bottom >= 0))
        return;
    if (out->depth)
        d = inverse_depth_of(a, b, c);
    for (int y = first_from(greater(top, 0)), y1 = last_to(less(bottom, height - 1)); y <= y1; y++) {
        double lo = INFINITY, hi = -INFINITY;
        cross_edge(a, b, y, &lo, &hi);
        cross_edge(b, c, y, &lo, &hi);
        cross_edge(c, a, y, &lo, &hi);
        if (lo <= hi && lo < width && hi >= 0)
            put_span(out, &d, y, first_from(greater(lo, 0)), last_to(less(hi, width - 1)));
    }
}

static lt_status draw(const lt_mesh *mesh, const float *R, const float *t, const lt_camera *cam, const canvas *out,
                      lt_arena *scratch)
{
    spot *p = lt_arena_array(scratch, (size_t)mesh->n_vertices, sizeof(*p));

    if (!p)
        return lt_error(LT_ENOMEM, "silhouette: no memory for %d vertices", mesh->n_vertices);
    for (int i = 0; i < mesh->n_vertices; i++)
        p[i] = project(mesh->vertex[i], R, t, cam);
    for (int i = 0; i < mesh->n_faces; i++) {
        const spot *a = &p[mesh->face[i][0]], *b = &p[mesh->face[i][1]], *c = &p[mesh->face[i][2]];
        if (a->z > NEAR && b->z > NEAR && c->z > NEAR)
            fill(a, b, c, out);
    }
    return LT_OK;
}

lt_status silhouette_draw(const lt_mesh *mesh, const float *R, const float *t, const lt_camera *cam,
                          uint8_t *mask, int width, int height, lt_arena *scratch)
{
    return draw(mesh, R, t, cam, &(canvas){ mask, NULL, width, height }, scratch);
}

lt_status silhouette_depth(const lt_mesh *mesh, const float *R, const float *t, const lt_camera *cam,
                           float *depth, int width, int height, lt_arena *scratch)
{
    memset(depth, 0, (size_t)width * (size_t)height * sizeof(*depth));
    return draw(mesh, R, t, cam, &(canvas){ NULL, depth, width, height }, scratch);
}
