/* SPDX-License-Identifier: Apache-2.0 */
/* Lines, discs, skeletons, masks, pictures in pictures. */
#include "vision/drawing/draw.h"

#include <math.h>
#include <string.h>

static uint8_t mix(uint8_t below, uint8_t above, float share)
{
    return (uint8_t)((float)below + share * ((float)above - (float)below) + 0.5f);
}

/* Covers share of one pixel. */
static void cover(draw_canvas *c, int x, int y, draw_color color, float share)
{
    uint8_t *p = c->rgb[(size_t)y * (size_t)c->width + (size_t)x];

    if (share <= 0)
        return;
    share = share < 1 ? share : 1;
    p[0] = mix(p[0], color.r, share);
    p[1] = mix(p[1], color.g, share);
    p[2] = mix(p[2], color.b, share);
}

draw_canvas draw_canvas_new(lt_arena *arena, int width, int height, draw_color fill)
{
    draw_canvas c = { NULL, width, height };

    if (width < 1 || height < 1 || width > DRAW_MAX_SIDE || height > DRAW_MAX_SIDE)
        return c;
    c.rgb = lt_arena_array(arena, (size_t)width * (size_t)height, sizeof(*c.rgb));
    if (c.rgb)
        draw_rect(&c, 0, 0, width, height, fill, 1);
    return c;
}

void draw_rect(draw_canvas *c, int x0, int y0, int x1, int y1, draw_color color, float opacity)
{
    for (int y = y0 < 0 ? 0 : y0; y < y1 && y < c->height; y++)
        for (int x = x0 < 0 ? 0 : x0; x < x1 && x < c->width; x++)
            cover(c, x, y, color, opacity);
}

/* ---- lines ----------------------------------------------------------------------------------- */

/* Cuts [*lo, *hi] of the parameter to where low <= a + t d <= high; false when nothing is left. */
static bool cut(double a, double d, double low, double high, double *lo, double *hi)
{
    if (d == 0)
        return a >= low && a <= high;
    const double t0 = (low - a) / d, t1 = (high - a) / d;

    *lo = fmax(*lo, fmin(t0, t1));
    *hi = fmin(*hi, fmax(t0, t1));
    return *lo <= *hi;
}

static double distance_to(const double a[2], const double d[2], double x, double y)
{
    const double length2 = d[0] * d[0] + d[1] * d[1];
    double t = length2 > 0 ? ((x - a[0]) * d[0] + (y - a[1]) * d[1]) / length2 : 0;

    t = fmin(fmax(t, 0), 1);
    return hypot(x - a[0] - t * d[0], y - a[1] - t * d[1]);
}

/* Walks the rows that the line touches, in each the pixels that lie within reach of it. */
void draw_line(draw_canvas *c, const float a[2], const float b[2], float width, draw_color color,
               float opacity)
{
    const double reach = width / 2 + 1, p[2] = { a[0], a[1] };
    const double d[2] = { (double)b[0] - a[0], (double)b[1] - a[1] };
    double lo = 0, hi = 1;

    if (!isfinite(a[0] + a[1] + b[0] + b[1]) || !(width > 0 && width < 1e4f) ||
        !cut(p[0], d[0], -reach, c->width + reach, &lo, &hi) ||
        !cut(p[1], d[1], -reach, c->height + reach, &lo, &hi))
        return;
    const double y0 = p[1] + lo * d[1], y1 = p[1] + hi * d[1];
    const double top = fmin(y0, y1), low = fmax(y0, y1);

    for (int y = (int)fmax(ceil(top - reach), 0); y <= low + reach && y < c->height; y++) {
        double t0 = lo, t1 = hi;

        if (!cut(p[1], d[1], y - reach, y + reach, &t0, &t1))
            continue;
        const double x0 = p[0] + t0 * d[0], x1 = p[0] + t1 * d[0];
        const double left = fmin(x0, x1) - reach, right = fmax(x0, x1) + reach;

        for (int x = (int)fmax(ceil(left), 0); x <= right && x < c->width; x++)
            cover(c, x, y, color, opacity * (float)fmin(width / 2 + 0.5 - distance_to(p, d, x, y), 1));
    }
}

void draw_disc(draw_canvas *c, const float center[2], float radius, draw_color color, float opacity)
{
    const float reach = radius + 1, x = center[0], y = center[1];

    if (!isfinite(x + y) || !(reach > 1 && reach < 1e4f) || x < -reach || y < -reach ||
        x > (float)c->width + reach || y > (float)c->height + reach)
        return;
    for (int v = (int)fmaxf(ceilf(y - reach), 0); (float)v <= y + reach && v < c->height; v++)
        for (int u = (int)fmaxf(ceilf(x - reach), 0); (float)u <= x + reach && u < c->width; u++) {
            const float d = hypotf((float)u - x, (float)v - y);

            cover(c, u, v, color, opacity * fminf(radius - d + 0.5f, 1));
        }
}

/* ---- hands and objects ----------------------------------------------------------------------- */

static const draw_color digit_color[5] = {
    { 230, 60, 60 }, { 245, 190, 50 }, { 80, 200, 90 }, { 60, 140, 240 }, { 180, 90, 220 },
};

void draw_skeleton(draw_canvas *c, const float (*joint)[2], float size)
{
    const draw_color dark = { 20, 20, 20 }, wrist = { 240, 240, 240 };

    for (int pass = 0; pass < 2; pass++)                /* a dark rim keeps bones apart */
        for (int i = 1; i < 21; i++) {
            const int from = i % 4 == 1 ? 0 : i - 1;

            draw_line(c, joint[from], joint[i], pass ? size / 2 : size / 2 + 1.5f,
                      pass ? digit_color[(i - 1) / 4] : dark, pass ? 1 : 0.6f);
        }
    for (int i = 0; i < 21; i++) {
        draw_disc(c, joint[i], size / 2 + 0.8f, dark, 0.6f);
        draw_disc(c, joint[i], size / 2, i ? digit_color[(i - 1) / 4] : wrist, 1);
    }
}

void draw_box(draw_canvas *c, const float (*corner)[2], float width, draw_color color)
{
    for (int i = 0; i < 8; i++)
        for (int axis = 1; axis < 8; axis *= 2)
            if (!(i & axis))
                draw_line(c, corner[i], corner[i | axis], width, color, 1);
}

void draw_wire(draw_canvas *c, const float (*vertex)[2], int n_vertices, const int32_t (*face)[3],
               int n_faces, draw_color color, float opacity)
{
    for (int f = 0; f < n_faces; f++)
        for (int i = 0; i < 3; i++) {
            const int a = face[f][i], b = face[f][(i + 1) % 3];

            if (a >= 0 && b >= 0 && a < n_vertices && b < n_vertices)
                draw_line(c, vertex[a], vertex[b], 1, color, opacity);
        }
}

/* ---- masks ----------------------------------------------------------------------------------- */

void draw_mask(draw_canvas *c, const uint8_t *mask, draw_color color, float opacity)
{
    for (int y = 0; y < c->height; y++)
        for (int x = 0; x < c->width; x++)
            if (mask[(size_t)y * (size_t)c->width + (size_t)x])
                cover(c, x, y, color, opacity);
}

static bool outside(const draw_canvas *c, const uint8_t *mask, int x, int y)
{
    return x < 0 || y < 0 || x >= c->width || y >= c->height ||
           !mask[(size_t)y * (size_t)c->width + (size_t)x];
}

static bool near_border(const draw_canvas *c, const uint8_t *mask, int x, int y, int width)
{
    for (int v = -width; v <= width; v++)
        for (int u = -width; u <= width; u++)
            if (u * u + v * v <= width * width && outside(c, mask, x + u, y + v))
                return true;
    return false;
}

void draw_outline(draw_canvas *c, const uint8_t *mask, int width, draw_color color)
{
    for (int y = 0; y < c->height; y++)
        for (int x = 0; x < c->width; x++)
            if (!outside(c, mask, x, y) && near_border(c, mask, x, y, width))
                cover(c, x, y, color, 1);
}

/* ---- pictures -------------------------------------------------------------------------------- */

/* The mean of the source pixels that a target pixel covers, at least one. */
static draw_color mean_of(const draw_canvas *p, int x0, int y0, int x1, int y1)
{
    uint32_t sum[3] = { 0 }, n = 0;

    x1 = x1 > x0 ? x1 : x0 + 1;
    y1 = y1 > y0 ? y1 : y0 + 1;
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++, n++)
            for (int k = 0; k < 3; k++)
                sum[k] += p->rgb[(size_t)y * (size_t)p->width + (size_t)x][k];
    return (draw_color){ (uint8_t)((sum[0] + n / 2) / n), (uint8_t)((sum[1] + n / 2) / n),
                         (uint8_t)((sum[2] + n / 2) / n) };
}

void draw_picture(draw_canvas *c, int x, int y, int w, int h, const draw_canvas *p)
{
    for (int v = 0; v < h; v++)
        for (int u = 0; u < w; u++) {
            const int64_t x0 = (int64_t)u * p->width / w, x1 = (int64_t)(u + 1) * p->width / w;
            const int64_t y0 = (int64_t)v * p->height / h, y1 = (int64_t)(v + 1) * p->height / h;

            if (x + u >= 0 && y + v >= 0 && x + u < c->width && y + v < c->height)
                cover(c, x + u, y + v, mean_of(p, (int)x0, (int)y0, (int)x1, (int)y1), 1);
        }
}
