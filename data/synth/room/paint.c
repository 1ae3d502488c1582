/* SPDX-License-Identifier: Apache-2.0 */
#include "data/synth/room/paint.h"

#include "libtensor/base/parallel.h"

#include <string.h>

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

typedef struct {
    paint_noise noise;
    uint32_t seed;
    float (*out)[PAINT_SIDE];
} field_job;

static void field_row(void *ctx, int64_t y)
{
    const field_job *job = ctx;
    const paint_noise *n = &job->noise;
    const float first = 1 / (2 - ldexpf(1, 1 - n->octaves));    /* all weights add to 1 */

    memset(job->out[y], 0, sizeof(job->out[y]));
    for (int o = 0; o < n->octaves; o++)
        add_octave(job->seed + n->salt + (uint32_t)o * 0x9e3779b9u, n->px << o, n->py << o, (int)y,
                   ldexpf(first, -o), job->out[y]);
}

/* ---- painting -------------------------------------------------------------------------------- */

/* What a texture is painted from. */
typedef struct { paint p; paint_fn fn; } recipe;

typedef struct {
    const paint *p;
    paint_fn fn;
    uint8_t (*rgb)[3];
} paint_job;

static void paint_row(void *ctx, int64_t y)
{
    const paint_job *job = ctx;

    for (int x = 0; x < PAINT_SIDE; x++) {
        float c[3];

        job->fn(job->p, ((float)x + 0.5f) / PAINT_SIDE, ((float)y + 0.5f) / PAINT_SIDE, c);
        for (int k = 0; k < 3; k++)
            job->rgb[(int)y * PAINT_SIDE + x][k] = paint_byte(c[k]);
    }
}

static bool make_fields(lt_arena *arena, paint *p)
{
    for (int i = 0; i < PAINT_FIELDS && p->noise[i].px; i++) {
        field_job job = { p->noise[i], p->seed, lt_arena_array(arena, PAINT_SIDE, sizeof(*job.out)) };

        if (!job.out)
            return false;
        lt_parallel_for(PAINT_SIDE, field_row, &job);
        p->field[i] = (const float (*)[PAINT_SIDE])job.out;
    }
    return true;
}

static bool follow(const void *ctx, int side, uint8_t (*rgb)[3])
{
    const recipe *from = ctx;
    lt_arena *scratch = lt_arena_new();
    paint p = from->p;
    const paint_job job = { &p, from->fn, rgb };
    bool ok;

    for (int x = 0; x < side && p.threads; x++)
        p.wave[x] = sinf(6.2831853f * (float)p.threads * ((float)x + 0.5f) / PAINT_SIDE);
    ok = scratch && make_fields(scratch, &p);
    if (ok)
        lt_parallel_for(side, paint_row, (void *)&job);
    lt_arena_free(scratch);
    return ok;
}

/* Most of what a room has no camera sees, so it is only noted down here. */
synth_texture *paint_texture(lt_arena *arena, const paint *p, paint_fn fn)
{
    recipe *r = lt_arena_alloc(arena, sizeof(*r));

    if (r)
        *r = (recipe){ *p, fn };
    return synth_texture_later(arena, PAINT_SIDE, follow, r);
}
