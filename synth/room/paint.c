/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/room/paint.h"

/* ---- noise ----------------------------------------------------------------------------------- */

static float value_noise(uint32_t seed, float u, float v, int px, int py)
{
    const float x = u * (float)px, y = v * (float)py;
    const int ix = (int)x, iy = (int)y;                 /* u, v below 1, or 1 by rounding */
    const int x0 = ix < px ? ix : 0, x1 = x0 + 1 < px ? x0 + 1 : 0;
    const int y0 = iy < py ? iy : 0, y1 = y0 + 1 < py ? y0 + 1 : 0;
    const float fx = x - (float)ix, fy = y - (float)iy;
    const float sx = fx * fx * (3 - 2 * fx), sy = fy * fy * (3 - 2 * fy);
    const float top = paint_lattice(seed, x0, y0) * (1 - sx) + paint_lattice(seed, x1, y0) * sx;
    const float low = paint_lattice(seed, x0, y1) * (1 - sx) + paint_lattice(seed, x1, y1) * sx;

    return top + sy * (low - top);
}

float paint_smooth_noise(uint32_t seed, float u, float v, int px, int py, int octaves)
{
    float sum = 0, weight = 0, w = 1;

    u -= (float)floor_int(u);
    v -= (float)floor_int(v);
    for (int o = 0; o < octaves; o++, w *= 0.5f) {
        sum += w * value_noise(seed + (uint32_t)o * 0x9e3779b9u, u, v, px << o, py << o);
        weight += w;
    }
    return sum / weight;
}

/* Adds one octave at row y: first the row's own lattice, then what lies between its points. */
static void add_octave(uint32_t seed, int px, int py, int y, float weight, float *out)
{
    const float at = ((float)y + 0.5f) / PAINT_SIDE * (float)py;
    const int y0 = (int)at, y1 = y0 + 1 < py ? y0 + 1 : 0;
    const float fy = at - (float)y0, sy = fy * fy * (3 - 2 * fy);
    float cell[PAINT_SIDE + 1];

    for (int i = 0; i < px; i++) {
        const float top = paint_lattice(seed, i, y0);

        cell[i] = top + sy * (paint_lattice(seed, i, y1) - top);
    }
    cell[px] = cell[0];
    for (int x = 0; x < PAINT_SIDE; x++) {
        const float u = ((float)x + 0.5f) / PAINT_SIDE * (float)px;
        const int i = (int)u;
        const float f = u - (float)i, s = f * f * (3 - 2 * f);

        out[x] += weight * (cell[i] + s * (cell[i + 1] - cell[i]));
    }
}

/* ---- painting -------------------------------------------------------------------------------- */

/* What a texture is painted from. */
typedef struct { paint p; paint_fn fn; } recipe;

static void add_noise(const paint *p, const paint_noise *n, int y, float out[PAINT_SIDE])
{
    const float first = 1 / (2 - ldexpf(1, 1 - n->octaves));    /* all weights add to 1 */

    for (int o = 0; o < n->octaves; o++)
        add_octave(p->seed + n->salt + (uint32_t)o * 0x9e3779b9u, n->px << o, n->py << o, y, ldexpf(first, -o), out);
}

/* The row's noises first, then its texels. */
static void paint_row(const void *from, int side, int y, uint8_t (*rgb)[3])
{
    const recipe *r = from;
    float noise[PAINT_FIELDS][PAINT_SIDE] = { { 0 } };
    paint p = r->p;

    for (int i = 0; i < PAINT_FIELDS; i++) {
        if (p.noise[i].px)
            add_noise(&p, &p.noise[i], y, noise[i]);
        p.field[i] = noise[i];
    }
    for (int x = 0; x < side; x++) {
        float c[3];

        r->fn(&p, ((float)x + 0.5f) / PAINT_SIDE, ((float)y + 0.5f) / PAINT_SIDE, c);
        for (int k = 0; k < 3; k++)
            rgb[x][k] = paint_byte(c[k]);
    }
}

/* Most of what a room has no camera sees, so it is only noted down here. */
synth_texture *paint_texture(lt_arena *arena, const paint *p, paint_fn fn)
{
    recipe *r = lt_arena_alloc(arena, sizeof(*r));

    if (!r)
        return NULL;
    *r = (recipe){ *p, fn };
    for (int x = 0; x < PAINT_SIDE && p->threads; x++)
        r->p.wave[x] = sinf(6.2831853f * (float)p->threads * ((float)x + 0.5f) / PAINT_SIDE);
    return synth_texture_later(arena, PAINT_SIDE, paint_row, r);
}
