/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles by their colours, nearest first, in the light of the camera. */
#include "vision/drawing/draw.h"

#include <math.h>

/* A corner on the screen: 1 / z is linear there, and so is what is over z. */
typedef struct { double u, v, inverse, colour[3]; } corner;

static double side(const corner *a, const corner *b, double u, double v)
{
    return (b->u - a->u) * (v - a->v) - (b->v - a->v) * (u - a->u);
}

static void draw_pixel(draw_canvas *c, float *nearness, const corner p[3], double area, int x, int y)
{
    const double w[3] = { side(&p[1], &p[2], x, y) / area, side(&p[2], &p[0], x, y) / area,
                          side(&p[0], &p[1], x, y) / area };
    const double inverse = w[0] * p[0].inverse + w[1] * p[1].inverse + w[2] * p[2].inverse;
    const int at = y * c->width + x;

    if (w[0] < 0 || w[1] < 0 || w[2] < 0 || inverse <= (double)nearness[at])
        return;
    nearness[at] = (float)inverse;
    for (int k = 0; k < 3; k++) {
        const double shade = w[0] * p[0].colour[k] + w[1] * p[1].colour[k] + w[2] * p[2].colour[k];

        c->rgb[at][k] = (uint8_t)lround(255 * fmin(1, fmax(0, shade)));
    }
}

/* x as a whole number, or the nearest end where it is outside */
static int within(double x, int lo, int hi)
{
    return (int)fmax(lo, fmin(hi, x));
}

static void draw_triangle(draw_canvas *c, float *nearness, const corner p[3])
{
    const double area = side(&p[0], &p[1], p[2].u, p[2].v);
    const int x0 = within(ceil(fmin(p[0].u, fmin(p[1].u, p[2].u))), 0, c->width);
    const int x1 = within(floor(fmax(p[0].u, fmax(p[1].u, p[2].u))), -1, c->width - 1);
    const int y0 = within(ceil(fmin(p[0].v, fmin(p[1].v, p[2].v))), 0, c->height);
    const int y1 = within(floor(fmax(p[0].v, fmax(p[1].v, p[2].v))), -1, c->height - 1);

    for (int y = y0; y <= y1 && area != 0; y++)
        for (int x = x0; x <= x1; x++)
            draw_pixel(c, nearness, p, area, x, y);
}

/* How much a face is turned towards the camera, 0 to 1 */
static double facing(const float *a, const float *b, const float *d)
{
    double n[3], length = 0, towards = 0, far = 0;

    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;

        n[k] = ((double)b[i] - (double)a[i]) * ((double)d[j] - (double)a[j])
            - ((double)b[j] - (double)a[j]) * ((double)d[i] - (double)a[i]);
        length += n[k] * n[k];
        towards += n[k] * (double)a[k];
        far += (double)a[k] * (double)a[k];
    }
    return length > 0 ? fabs(towards) / sqrt(length * far) : 0;
}

void draw_mesh(draw_canvas *c, float *nearness, const lt_camera *camera, const lt_mesh *m)
{
    for (int i = 0; i < m->n_faces; i++) {
        const int32_t *face = m->face[i];
        const double light = 0.55 + 0.45 * facing(m->vertex[face[0]], m->vertex[face[1]], m->vertex[face[2]]);
        bool seen = true;
        corner p[3];

        for (int j = 0; j < 3; j++) {
            const float *x = m->vertex[face[j]];

            seen = seen && x[2] > 0 && isfinite(x[0]) && isfinite(x[1]) && isfinite(x[2]);
            p[j] = (corner){ camera->fx * (double)x[0] / (double)x[2] + camera->cx,
                             camera->fy * (double)x[1] / (double)x[2] + camera->cy, 1 / (double)x[2], { 0 } };
            for (int k = 0; k < 3; k++)
                p[j].colour[k] = light * (m->color ? (double)m->color[face[j]][k] : 0.8);
        }
        if (seen)
            draw_triangle(c, nearness, p);
    }
}
