/* SPDX-License-Identifier: Apache-2.0 */
#include "vision/depth.h"

#include "vision/crop.h"

#include <math.h>
#include <stdlib.h>

static const float RANGE = 0.30f;               /* metres on each side of the middle */

static int by_size(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;

    return x < y ? -1 : x > y;
}

/* The median of what is known of [low, high) x [low, high), of the mask alone where there is one; 0: nothing is. */
static float middle(const double back[6], const float *crop, const uint8_t *mask, int width, int height, int size,
                    int low, int high, float *scratch)
{
    size_t n = 0;

    for (int y = low; y < high; y++)
        for (int x = low; x < high; x++) {
            const float z = crop[(size_t)y * (size_t)size + (size_t)x];

            if (z > 0 && (!mask || mask[crop_source(back, width, height, x, y)]))
                scratch[n++] = z;
        }
    qsort(scratch, n, sizeof(*scratch), by_size);
    return n ? scratch[n / 2] : 0;
}

void depth_crop(const double A[6], const float *depth, const uint8_t *mask, int width, int height,
                float *metres, float *out, int size, float *scratch)
{
    const size_t n = (size_t)size * (size_t)size;
    double back[6];
    float d = 0;

    crop_inverse(A, back);
    for (size_t i = 0; i < n; i++) {
        const int x = (int)(i % (size_t)size), y = (int)(i / (size_t)size);
        const int64_t at = depth ? crop_source(back, width, height, x, y) : -1;

        metres[i] = at >= 0 && isfinite(depth[at]) ? depth[at] : 0;
    }
    if (mask)
        d = middle(back, metres, mask, width, height, size, 0, size, scratch);
    if (d == 0)
        d = middle(back, metres, NULL, width, height, size, size / 3, size - size / 3, scratch);
    for (size_t i = 0; i < n; i++)
        out[i] = metres[i] > 0 ? fmaxf(-1, fminf(1, (metres[i] - d) / RANGE)) : 1;
}
