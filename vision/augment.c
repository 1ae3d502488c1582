/* SPDX-License-Identifier: Apache-2.0 */
/* Colour jitter and blur. */
#include "vision/augment.h"

#include <math.h>

static float clamp01(double v)
{
    return v < 0 ? 0 : v > 1 ? 1 : (float)v;
}

/* ITU-R 601 luma with the digits torchvision has. */
static double grey(const float *image, int64_t n, int64_t i)
{
    return 0.2989 * image[i] + 0.587 * image[n + i] + 0.114 * image[2 * n + i];
}

void augment_brightness(float *image, int64_t n, double factor)
{
    for (int64_t i = 0; i < 3 * n; i++)
        image[i] = clamp01(factor * image[i]);
}

void augment_contrast(float *image, int64_t n, double factor)
{
    double mean = 0;

    for (int64_t i = 0; i < n; i++)
        mean += grey(image, n, i);
    mean = n ? mean / (double)n : 0;
    for (int64_t i = 0; i < 3 * n; i++)
        image[i] = clamp01(factor * image[i] + (1 - factor) * mean);
}

void augment_saturation(float *image, int64_t n, double factor)
{
    for (int64_t i = 0; i < n; i++) {
        const double g = grey(image, n, i);
        for (int c = 0; c < 3; c++)
            image[c * n + i] = clamp01(factor * image[c * n + i] + (1 - factor) * g);
    }
}

/* Without libm's calls, a quarter of the time that a sample's colours take. */
static double greater(double a, double b) { return a > b ? a : b; }
static double less(double a, double b) { return a < b ? a : b; }

/* Hue in turns, saturation and value of an RGB colour. */
static void rgb_to_hsv(const double c[3], double hsv[3])
{
    const double hi = greater(c[0], greater(c[1], c[2])), lo = less(c[0], less(c[1], c[2]));
    const double span = hi - lo, d = span > 0 ? span : 1;
    double h;

    if (hi == c[0])
        h = (c[1] - c[2]) / d;
    else if (hi == c[1])
        h = 2 + (c[2] - c[0]) / d;
    else
        h = 4 + (c[0] - c[1]) / d;
    h = h / 6 + 1;
    hsv[0] = h >= 1 ? h - 1 : h;
    hsv[1] = hi > 0 ? span / hi : 0;
    hsv[2] = hi;
}

static void hsv_to_rgb(const double hsv[3], double c[3])
{
    enum { V, P, Q, T };
    static const uint8_t which[6][3] = {
        { V, T, P }, { Q, V, P }, { P, V, T }, { P, Q, V }, { T, P, V }, { V, P, Q },
    };
    const double h = hsv[0] * 6, v = hsv[2], f = h - (int)h;
    const double of[4] = { v, v * (1 - hsv[1]), v * (1 - hsv[1] * f), v * (1 - hsv[1] * (1 - f)) };

    for (int k = 0; k < 3; k++)
        c[k] = of[which[(int)h % 6][k]];
}

void augment_hue(float *image, int64_t n, double shift)
{
    for (int64_t i = 0; i < n; i++) {
        double c[3] = { image[i], image[n + i], image[2 * n + i] }, hsv[3];
        rgb_to_hsv(c, hsv);
        hsv[0] += shift + 1;
        hsv[0] -= (int)hsv[0];
        hsv_to_rgb(hsv, c);
        for (int k = 0; k < 3; k++)
            image[k * n + i] = clamp01(c[k]);
    }
}

void augment_hsv(float *image, int64_t n, double hue, double saturation, double value)
{
    for (int64_t i = 0; i < n; i++) {
        double c[3] = { image[i], image[n + i], image[2 * n + i] }, hsv[3];

        rgb_to_hsv(c, hsv);
        hsv[0] *= hue;
        hsv[0] -= (int)hsv[0];
        hsv[1] = less(hsv[1] * saturation, 1);
        hsv[2] = less(hsv[2] * value, 1);
        hsv_to_rgb(hsv, c);
        for (int k = 0; k < 3; k++)
            image[k * n + i] = clamp01(c[k]);
    }
}

enum { BLUR_REACH = 3 };            /* three deviations of a radius below 1 */

/* One line of n pixels, step apart, from in to out. */
static void blur_line(const float *in, float *out, int n, int64_t step, const double *w)
{
    for (int i = 0; i < n; i++) {
        double sum = 0;
        for (int k = -BLUR_REACH; k <= BLUR_REACH; k++) {
            const int j = i + k < 0 ? 0 : i + k >= n ? n - 1 : i + k;
            sum += w[k + BLUR_REACH] * in[j * step];
        }
        out[i * step] = (float)sum;
    }
}

static void blur_weights(double radius, double w[2 * BLUR_REACH + 1])
{
    double sum = 0;

    for (int k = -BLUR_REACH; k <= BLUR_REACH; k++)
        sum += w[k + BLUR_REACH] = exp(-k * k / (2 * radius * radius));
    for (int k = 0; k <= 2 * BLUR_REACH; k++)
        w[k] /= sum;
}

void augment_blur(float *image, int height, int width, double radius, float *scratch)
{
    const int64_t plane = (int64_t)height * width;
    double w[2 * BLUR_REACH + 1];

    if (radius < 0.05)              /* the neighbours' share is below 1e-80 */
        return;
    blur_weights(radius, w);
    for (int c = 0; c < 3; c++) {
        float *p = image + c * plane;
        for (int y = 0; y < height; y++)
            blur_line(p + (int64_t)y * width, scratch + (int64_t)y * width, width, 1, w);
        for (int x = 0; x < width; x++)
            blur_line(scratch + x, p + x, height, width, w);
    }
}

void augment_colour(float *image, int height, int width, const augment_limits *lim, lt_rng *rng,
                    float *scratch)
{
    const int64_t n = (int64_t)height * width;
    const double blur = lt_rng_range(rng, 0, lim->blur);
    const double brightness = lt_rng_range(rng, 1 - lim->brightness, 1 + lim->brightness);
    const double contrast = lt_rng_range(rng, 1 - lim->contrast, 1 + lim->contrast);
    const double saturation = lt_rng_range(rng, 1 - lim->saturation, 1 + lim->saturation);
    const double hue = lt_rng_range(rng, -lim->hue, lim->hue);
    uint32_t order[4];

    lt_rng_permute(rng, order, 4);
    augment_blur(image, height, width, blur, scratch);
    for (int i = 0; i < 4; i++) {
        switch (order[i]) {
        case 0: augment_brightness(image, n, brightness); break;
        case 1: augment_contrast(image, n, contrast); break;
        case 2: augment_saturation(image, n, saturation); break;
        case 3: augment_hue(image, n, hue); break;
        }
    }
}
