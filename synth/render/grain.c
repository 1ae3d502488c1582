/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/render/grain.h"
#include "synth/render/small.h"

#include <stdint.h>

static const float SPOT = 0.008f, PORE = 0.003f, FURROW = 0.0022f;      /* wavelengths, metres */

static float lattice(int x, int y, int z)
{
    uint32_t h = (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u ^ (uint32_t)z * 0xcb1ab31fu;

    h = (h ^ h >> 15) * 0x2c1b3c6du;
    return (float)((h ^ h >> 12) >> 8) / 16777216;
}

/* Value noise in space, -0.5 .. 0.5, and its slope per cell. */
static float noise(const float q[3], float wavelength, float slope[3])
{
    float f[3], s[3], d[3], v[8];
    int c[3];

    for (int i = 0; i < 3; i++) {
        const float x = q[i] / wavelength;

        c[i] = floor_int(x);
        f[i] = x - (float)c[i];
        s[i] = f[i] * f[i] * (3 - 2 * f[i]);
        d[i] = 6 * f[i] * (1 - f[i]);
    }
    for (int k = 0; k < 8; k++)
        v[k] = lattice(c[0] + (k & 1), c[1] + (k >> 1 & 1), c[2] + (k >> 2));
    const float x00 = v[0] + s[0] * (v[1] - v[0]), x10 = v[2] + s[0] * (v[3] - v[2]);
    const float x01 = v[4] + s[0] * (v[5] - v[4]), x11 = v[6] + s[0] * (v[7] - v[6]);
    const float y0 = x00 + s[1] * (x10 - x00), y1 = x01 + s[1] * (x11 - x01);
    const float dx0 = (v[1] - v[0]) + s[1] * ((v[3] - v[2]) - (v[1] - v[0]));
    const float dx1 = (v[5] - v[4]) + s[1] * ((v[7] - v[6]) - (v[5] - v[4]));

    slope[0] = d[0] * (dx0 + s[2] * (dx1 - dx0));
    slope[1] = d[1] * ((x10 - x00) + s[2] * ((x11 - x01) - (x10 - x00)));
    slope[2] = d[2] * (y1 - y0);
    return y0 + s[2] * (y1 - y0) - 0.5f;
}

/* How much of a wavelength is left when each pixel averages over its own width. */
static float visible(float wavelength, float pixel)
{
    return within(1.5f - 2 * pixel / wavelength, 0, 1);
}

void grain_apply(const float q[3], float strength, float pixel, float albedo[3], float normal[3])
{
    static const float blood[3] = { 0.35f, 1, 0.9f };           /* spots are redder, not only darker */
    float slope[3], spots;

    if (!(dot3(q, q) < 1e4f))
        return;
    spots = 0.2f * visible(SPOT, pixel) * noise(q, SPOT, slope) +
            0.16f * visible(PORE, pixel) * noise(q, PORE, slope);
    for (int i = 0; i < 3; i++)
        albedo[i] *= 1 + strength * blood[i] * spots;
    noise(q, FURROW, slope);
    for (int i = 0; i < 3; i++)
        normal[i] += 0.09f * strength * visible(FURROW, pixel) * slope[i];
    normalise3(normal);
}
