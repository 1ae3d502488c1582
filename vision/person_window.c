/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/person_window.h"

enum { MOST_PLACES = 8 };                       /* a side, in a pixel */

static const double GROWN = 1.25;

person_window person_window_around(const double b[4], int width, int height)
{
    const double aspect = (double)width / height;
    const double w = fmax(b[2] - b[0], aspect * (b[3] - b[1])) * GROWN, scale = width / w;
    const double x0 = (b[0] + b[2]) / 2 - w / 2, y0 = (b[1] + b[3]) / 2 - w / aspect / 2;

    return (person_window){ .scale = scale, .shift = { -scale * x0, -scale * y0 } };
}

/* Adds the picture at a place between its pixels */
static void add_place(const lt_image *from, double x, double y, float sum[3])
{
    const double left = floor(x), top = floor(y);
    const float fx = (float)(x - left), fy = (float)(y - top);

    if (!(left >= -1 && left < from->width && top >= -1 && top < from->height))
        return;
    for (int k = 0; k < 4; k++) {
        const int xk = (int)left + k % 2, yk = (int)top + k / 2;
        const float share = (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy);

        if (xk >= 0 && xk < from->width && yk >= 0 && yk < from->height && share > 0)
            for (int c = 0; c < 3; c++)
                sum[c] += share * (float)from->data[3 * ((size_t)yk * (size_t)from->width + (size_t)xk) + (size_t)c];
    }
}

void person_window_cut(const person_window *w, const lt_image *rgb, int width, int height, float *out)
{
    const int n = (int)fmax(1, fmin(MOST_PLACES, floor(1 / w->scale)));
    const double c = cos(w->turn) / w->scale, s = sin(w->turn) / w->scale;
    const size_t plane = (size_t)width * (size_t)height;

    for (int v = 0; v < height; v++)
        for (int u = 0; u < width; u++) {
            float sum[3] = { 0, 0, 0 };

            for (int k = 0; k < n * n; k++) {
                const double x = u + (k % n + 0.5) / n - 0.5 - w->shift[0],
                    y = v + (k / n + 0.5) / n - 0.5 - w->shift[1];

                add_place(rgb, c * x + s * y, c * y - s * x, sum);
            }
            for (int k = 0; k < 3; k++)
                out[(size_t)k * plane + (size_t)v * (size_t)width + (size_t)u] = sum[k] / (float)(n * n) / 255;
        }
}
