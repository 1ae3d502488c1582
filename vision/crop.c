/* SPDX-License-Identifier: Apache-2.0 */
/* Boxes, crop windows, affine maps, and warping an image or a mask through one. */
#include "vision/crop.h"

#include "libtensor/geometry/mat3.h"

#include <assert.h>
#include <math.h>

crop_box crop_extent(const float (*p)[2], int n)
{
    crop_box b = { p[0][0], p[0][1], p[0][0], p[0][1] };

    for (int i = 1; i < n; i++) {
        b.x0 = fminf(b.x0, p[i][0]);
        b.y0 = fminf(b.y0, p[i][1]);
        b.x1 = fmaxf(b.x1, p[i][0]);
        b.y1 = fmaxf(b.y1, p[i][1]);
    }
    return b;
}

crop_box crop_box_around(const float (*point)[2], int n, double factor)
{
    const crop_box e = crop_extent(point, n);
    const double cx = trunc(((double)e.x0 + e.x1) / 2), cy = trunc(((double)e.y0 + e.y1) / 2);
    const double hx = ((double)e.x1 - e.x0) * factor / 2, hy = ((double)e.y1 - e.y0) * factor / 2;

    return (crop_box){ (float)(cx - hx), (float)(cy - hy), (float)(cx + hx), (float)(cy + hy) };
}

crop_window crop_window_around(crop_box hand, crop_box object, int width, int height)
{
    const double x0 = fmax(0, fminf(hand.x0, object.x0)), y0 = fmax(0, fminf(hand.y0, object.y0));
    const double x1 = fmin(width, fmaxf(hand.x1, object.x1));
    const double y1 = fmin(height, fmaxf(hand.y1, object.y1));
    const double side = fmax(x1 - x0, y1 - y0);

    return (crop_window){
        .cx = trunc((x0 + x1) / 2),
        .cy = trunc((y0 + y1) / 2),
        .side = fmax(side, 1),              /* everything outside the image: a crop of one pixel */
    };
}

crop_window crop_window_hull(crop_box b)
{
    return (crop_window){
        .cx = ((double)b.x0 + b.x1) / 2, .cy = ((double)b.y0 + b.y1) / 2,
        .side = fmax(1, fmax((double)b.x1 - b.x0, (double)b.y1 - b.y0)),
    };
}

void crop_affine(crop_window w, int size, double A[6])
{
    lt_affine_crop(w.cx, w.cy, w.side, w.angle, size, A);
}

void crop_inverse(const double A[6], double back[6])
{
    const lt_status st = lt_affine_inverse(A, back);

    assert(!st);
    (void)st;
}

void crop_points(const double A[6], const float (*in)[2], int n, float (*out)[2])
{
    for (int i = 0; i < n; i++) {
        double p[2] = { in[i][0], in[i][1] };
        lt_affine_apply(A, p, p);
        out[i][0] = (float)p[0];
        out[i][1] = (float)p[1];
    }
}

crop_box crop_corners(const double A[6], crop_box b)
{
    const float in[2][2] = { { b.x0, b.y0 }, { b.x1, b.y1 } };
    float out[2][2];

    crop_points(A, in, 2, out);
    return (crop_box){ out[0][0], out[0][1], out[1][0], out[1][1] };
}

void crop_intrinsics(const double A[6], const lt_camera *cam, float *out)
{
    const double a[9] = { A[0], A[1], A[2], A[3], A[4], A[5], 0, 0, 1 };
    const double K[9] = { cam->fx, 0, cam->cx, 0, cam->fy, cam->cy, 0, 0, 1 };
    double AK[9];

    lt_mat3_mul(a, K, AK);
    for (int i = 0; i < 9; i++)
        out[i] = (float)AK[i];
}

lt_camera crop_whole_camera(const float A[6], const float K[9])
{
    return (lt_camera){ K[0] / A[0], K[4] / A[4], (K[2] - A[2]) / A[0], (K[5] - A[5]) / A[4] };
}

void crop_normalise(crop_box b, const float (*in)[2], int n, float (*out)[2])
{
    const float w = b.x1 > b.x0 ? b.x1 - b.x0 : 1, h = b.y1 > b.y0 ? b.y1 - b.y0 : 1;

    for (int i = 0; i < n; i++) {
        out[i][0] = (in[i][0] - b.x0) / w;
        out[i][1] = (in[i][1] - b.y0) / h;
    }
}

/* The pixel of the image at whole place (x, y), `outside` around it. */
static void fetch(const uint8_t *rgb, int width, int height, const float outside[3], double x, double y,
                  double out[3])
{
    const uint8_t *p;

    for (int c = 0; c < 3; c++)
        out[c] = outside[c];
    if (!(x >= 0 && x < width && y >= 0 && y < height))
        return;
    p = rgb + 3 * ((size_t)y * (size_t)width + (size_t)x);
    for (int c = 0; c < 3; c++)
        out[c] = p[c] / 255.0;
}

/* The four pixels around (u, v), whose centres are at half numbers here. */
typedef struct {
    double x, y, fx, fy;            /* the upper left one's place, and how far (u, v) lies behind it */
} around;

static around around_of(double u, double v)
{
    const double x = floor(u - 0.5), y = floor(v - 0.5);

    return (around){ x, y, u - 0.5 - x, v - 0.5 - y };
}

static double blend(const around *a, double p0, double p1, double p2, double p3)
{
    return (1 - a->fy) * ((1 - a->fx) * p0 + a->fx * p1) + a->fy * ((1 - a->fx) * p2 + a->fx * p3);
}

/* All four lie in the image, n bytes a row. */
static void blend_inside(const around *a, const uint8_t *rgb, size_t n, const double scaled[256], double out[3])
{
    const uint8_t *p = rgb + (size_t)a->y * n + 3 * (size_t)a->x, *q = p + n;

    for (int c = 0; c < 3; c++)
        out[c] = blend(a, scaled[p[c]], scaled[p[3 + c]], scaled[q[c]], scaled[q[3 + c]]);
}

static void blend_at_edge(const around *a, const uint8_t *rgb, int width, int height, const float outside[3],
                          double out[3])
{
    double p[4][3];

    for (int i = 0; i < 4; i++)
        fetch(rgb, width, height, outside, a->x + (i & 1), a->y + (i >> 1), p[i]);
    for (int c = 0; c < 3; c++)
        out[c] = blend(a, p[0][c], p[1][c], p[2][c], p[3][c]);
}

static void warp_bilinear(const double back[6], const uint8_t *rgb, int width, int height, float *out, int size,
                          const float outside[3])
{
    const size_t plane = (size_t)size * (size_t)size, row = 3 * (size_t)width;
    double scaled[256];

    for (int i = 0; i < 256; i++)
        scaled[i] = i / 255.0;
    for (int y = 0; y < size; y++)
        for (int x = 0; x < size; x++, out++) {
            double p[2], c[3];
            around a;

            crop_place(back, x, y, p);
            a = around_of(p[0], p[1]);
            if (a.x >= 0 && a.x + 1 < width && a.y >= 0 && a.y + 1 < height)
                blend_inside(&a, rgb, row, scaled, c);
            else
                blend_at_edge(&a, rgb, width, height, outside, c);
            for (size_t k = 0; k < 3; k++)
                out[k * plane] = (float)c[k];
        }
}

/* Row y of the warp, each pixel the nearest one there. */
static void warp_row_nearest(const double back[6], const uint8_t *rgb, int width, int height, int y, float *out,
                             int size, const float scaled[256], const float outside[3])
{
    const size_t plane = (size_t)size * (size_t)size;

    for (int x = 0; x < size; x++) {
        const int64_t at = crop_source(back, width, height, x, y);

        for (size_t k = 0; k < 3; k++)
            out[k * plane + (size_t)x] = at < 0 ? outside[k] : scaled[rgb[3 * (size_t)at + k]];
    }
}

static void warp_nearest(const double back[6], const uint8_t *rgb, int width, int height, float *out, int size,
                         const float outside[3])
{
    float scaled[256];

    for (int i = 0; i < 256; i++)
        scaled[i] = (float)(i / 255.0);
    for (int y = 0; y < size; y++)
        warp_row_nearest(back, rgb, width, height, y, out + (size_t)y * (size_t)size, size, scaled,
                         outside);
}

void crop_warp(const double A[6], const uint8_t *rgb, int width, int height, const float outside[3], float *out,
               int size, bool bilinear)
{
    static const float black[3];
    const float *edge = outside ? outside : black;
    double back[6];

    crop_inverse(A, back);
    if (bilinear)
        warp_bilinear(back, rgb, width, height, out, size, edge);
    else
        warp_nearest(back, rgb, width, height, out, size, edge);
}

/* The warped mask at whole crop pixel (x, y). */
static bool masked(const double back[6], const uint8_t *mask, int width, int height, int size,
                   long x, long y)
{
    int64_t at;

    if (x < 0 || x >= size || y < 0 || y >= size)
        return false;
    at = crop_source(back, width, height, (int)x, (int)y);
    return at >= 0 && mask[at] != 0;
}

void crop_mask(const double A[6], const uint8_t *mask, int width, int height, int size,
               crop_box box, float *out, int cells)
{
    const long x0 = lroundf(box.x0), y0 = lroundf(box.y0);
    const long w = lt_max_i64(1, lroundf(box.x1) - x0), h = lt_max_i64(1, lroundf(box.y1) - y0);
    double back[6];

    crop_inverse(A, back);
    for (int i = 0; i < cells; i++)
        for (int j = 0; j < cells; j++)
            out[i * cells + j] = masked(back, mask, width, height, size,
                                        x0 + (2 * j + 1) * w / (2 * cells),
                                        y0 + (2 * i + 1) * h / (2 * cells));
}
