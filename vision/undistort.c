/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/undistort.h"

#include "libtensor/base/parallel.h"

#include <math.h>
#include <string.h>

typedef struct {
    const undistortion *u;
    double fold2;                   /* squared distance at depth 1 behind which there is no picture */
    const uint8_t *rgb;
    uint8_t *rgb_out;
    const float *depth;
    float *depth_out;
} job;

static double farthest_corner(const undistortion *u)
{
    const double x = fmax(fabs(u->camera.cx), fabs(u->width - 1 - u->camera.cx)) / u->camera.fx;
    const double y = fmax(fabs(u->camera.cy), fabs(u->height - 1 - u->camera.cy)) / u->camera.fy;

    return hypot(x, y);
}

/* Where the lens put what a pinhole sees at (x, y); false: nowhere in the picture. */
static bool source(const job *j, int x, int y, double uv[2])
{
    const lt_camera *c = &j->u->camera;
    double p[2] = { (x - c->cx) / c->fx, (y - c->cy) / c->fy };

    if (p[0] * p[0] + p[1] * p[1] >= j->fold2)
        return false;
    lt_lens_distort(&j->u->lens, p, p);
    uv[0] = p[0] * c->fx + c->cx;
    uv[1] = p[1] * c->fy + c->cy;
    return uv[0] > -1 && uv[1] > -1 && uv[0] < j->u->width && uv[1] < j->u->height;
}

/* One sample, whose neighbours outside are black. */
static void blend(const job *j, const double uv[2], uint8_t out[3])
{
    const int width = j->u->width, height = j->u->height, x0 = (int)floor(uv[0]), y0 = (int)floor(uv[1]);
    double sum[3] = { 0 };

    for (int k = 0; k < 4; k++) {
        const int x = x0 + (k & 1), y = y0 + (k >> 1);
        const double weight = (1 - fabs(uv[0] - x)) * (1 - fabs(uv[1] - y));

        if (x < 0 || y < 0 || x >= width || y >= height)
            continue;
        for (int c = 0; c < 3; c++)
            sum[c] += weight * j->rgb[3 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c];
    }
    for (int c = 0; c < 3; c++)
        out[c] = (uint8_t)lround(sum[c]);
}

static void rgb_row(void *ctx, int64_t y)
{
    const job *j = ctx;
    uint8_t *out = j->rgb_out + 3 * (size_t)y * (size_t)j->u->width;
    double uv[2];

    for (int x = 0; x < j->u->width; x++, out += 3)
        if (source(j, x, (int)y, uv))
            blend(j, uv, out);
        else
            memset(out, 0, 3);
}

static void depth_row(void *ctx, int64_t y)
{
    const job *j = ctx;
    const int width = j->u->width;
    double uv[2];

    for (int x = 0; x < width; x++) {
        float d = 0;

        if (source(j, x, (int)y, uv)) {
            const long u = lround(uv[0]), v = lround(uv[1]);

            if (u >= 0 && v >= 0 && u < width && v < j->u->height)
                d = j->depth[v * width + u];
        }
        j->depth_out[y * width + x] = d;
    }
}

void undistort_rgb(const undistortion *u, const uint8_t *rgb, uint8_t *out)
{
    const double fold = undistort_fold(u);
    job j = { .u = u, .fold2 = fold * fold, .rgb = rgb, .rgb_out = out };

    lt_parallel_for(u->height, rgb_row, &j);
}

void undistort_depth(const undistortion *u, const float *depth, float *out)
{
    const double fold = undistort_fold(u);
    job j = { .u = u, .fold2 = fold * fold, .depth = depth, .depth_out = out };

    lt_parallel_for(u->height, depth_row, &j);
}

/* A lens bends the sides of a box: their middles may lie farther out than corners do. */
crop_box undistort_box(const undistortion *u, crop_box b)
{
    const lt_camera *c = &u->camera;
    const float xs[3] = { b.x0, (b.x0 + b.x1) / 2, b.x1 }, ys[3] = { b.y0, (b.y0 + b.y1) / 2, b.y1 };
    crop_box out = { INFINITY, INFINITY, -INFINITY, -INFINITY };

    for (int i = 0; i < 9; i++) {
        double p[2] = { ((double)xs[i % 3] - c->cx) / c->fx, ((double)ys[i / 3] - c->cy) / c->fy };

        lt_lens_undistort(&u->lens, p, p);
        out.x0 = fminf(out.x0, (float)(p[0] * c->fx + c->cx));
        out.y0 = fminf(out.y0, (float)(p[1] * c->fy + c->cy));
        out.x1 = fmaxf(out.x1, (float)(p[0] * c->fx + c->cx));
        out.y1 = fmaxf(out.y1, (float)(p[1] * c->fy + c->cy));
    }
    return out;
}

double undistort_fold(const undistortion *u)
{
    return lt_lens_fold(&u->lens, farthest_corner(u));
}
