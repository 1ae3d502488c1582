/* SPDX-License-Identifier: Apache-2.0 */
#include "data/detection/polygon.h"

#include <math.h>

/* Where an edge crosses the middle of a row, as x; false: it does not. An edge has its upper end, not its lower one. */
static bool crosses(const float *a, const float *b, double y, double *x)
{
    if ((a[1] <= y) == (b[1] <= y))
        return false;
    *x = a[0] + (y - a[1]) / ((double)b[1] - a[1]) * ((double)b[0] - a[0]);
    return true;
}

/* The first pixel whose centre is not left of x */
static int pixel_from(double x, int width)
{
    const double first = ceil(x - 0.5);

    return first <= 0 ? 0 : first >= width ? width : (int)first;
}

/* Each crossing turns what lies right of it: an inside becomes an outside. */
static void fill_row(const float *point, int n, int y, int width, uint8_t *row)
{
    double x;

    for (int i = 0; i < n; i++)
        if (crosses(point + 2 * i, point + 2 * ((i + 1) % n), y + 0.5, &x))
            for (int k = pixel_from(x, width); k < width; k++)
                row[k] ^= 2;
    for (int k = 0; k < width; k++)
        row[k] = row[k] ? 1 : 0;
}

/* Pixels on the way from a to b, as many steps as the longer side has pixels */
static void draw_edge(const float *a, const float *b, int width, int height, uint8_t *mask)
{
    const double dx = (double)b[0] - a[0], dy = (double)b[1] - a[1];
    const double steps = fmin(ceil(fmax(fabs(dx), fabs(dy))), 4.0 * (width + height));

    for (double i = 0; i <= steps; i++) {
        const double t = steps > 0 ? i / steps : 0, x = floor(a[0] + t * dx), y = floor(a[1] + t * dy);

        if (x >= 0 && y >= 0 && x < width && y < height)
            mask[(size_t)y * (size_t)width + (size_t)x] = 1;
    }
}

void polygon_fill(const float *point, int n, bool border, int width, int height, uint8_t *mask)
{
    double low = INFINITY, high = -INFINITY;

    for (int i = 0; i < n; i++) {
        low = fmin(low, (double)point[2 * i + 1]);
        high = fmax(high, (double)point[2 * i + 1]);
    }
    for (int y = pixel_from(low, height); y < height && y + 0.5 < high; y++)
        fill_row(point, n, y, width, mask + (size_t)y * (size_t)width);
    for (int i = 0; border && i < n; i++)
        draw_edge(point + 2 * i, point + 2 * ((i + 1) % n), width, height, mask);
}
