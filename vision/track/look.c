/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/track/look.h"

#include <math.h>

static const double PERSON_ASPECT = 0.5;        /* width over height */

/* The part of it that is in the picture; false: none is */
static bool inside(const lt_image *rgb, const float box[4], bool person, double b[4])
{
    const double w = person ? PERSON_ASPECT * ((double)box[3] - (double)box[1]) : (double)box[2] - (double)box[0];
    const double x = ((double)box[0] + (double)box[2]) / 2;

    b[0] = fmax(x - w / 2, 0);
    b[1] = fmax((double)box[1], 0);
    b[2] = fmin(x + w / 2, rgb->width);
    b[3] = fmin((double)box[3], rgb->height);
    return isfinite(x + w) && isfinite(box[1] + box[3]) && b[2] > b[0] && b[3] > b[1];
}

/* The two pixels of a row or column that are mixed for output pixel i of n, and the share of the second */
static double between(double lo, double hi, int i, int n, int size, int pair[2])
{
    const double at = fmin(fmax(lo + (i + 0.5) * (hi - lo) / n - 0.5, 0), size - 1);

    pair[0] = (int)at;
    pair[1] = pair[0] + 1 < size ? pair[0] + 1 : pair[0];
    return at - pair[0];
}

bool look_cut(const lt_image *rgb, const float box[4], bool person, int width, int height, float *out)
{
    double b[4];

    if (!inside(rgb, box, person, b))
        return false;
    for (int y = 0; y < height; y++) {
        int row[2];
        const double v = between(b[1], b[3], y, height, rgb->height, row);

        for (int x = 0; x < width; x++) {
            int col[2];
            const double u = between(b[0], b[2], x, width, rgb->width, col);

            for (int c = 0; c < 3; c++) {
                double mixed[2];

                for (int k = 0; k < 2; k++) {
                    const uint8_t *line = rgb->data + 3 * (size_t)row[k] * (size_t)rgb->width + c;

                    mixed[k] = (1 - u) * line[3 * col[0]] + u * line[3 * col[1]];
                }
                out[((size_t)c * (size_t)height + (size_t)y) * (size_t)width + (size_t)x] =
                    (float)(((1 - v) * mixed[0] + v * mixed[1]) / 255);
            }
        }
    }
    return true;
}
