/* SPDX-License-Identifier: Apache-2.0 */
/* Textures painted texel by texel from a few numbers, when they are first drawn with. */
#ifndef SYNTH_ROOM_PAINT_H
#define SYNTH_ROOM_PAINT_H

#include "synth/render/render.h"
#include "synth/render/small.h"

enum { PAINT_SIDE = 512, PAINT_FIELDS = 2 };

/* paint_smooth_noise at every texel: px = 0: none */
typedef struct {
    uint32_t salt;                  /* added to the paint's seed */
    int px, py, octaves;            /* px << octaves - 1 is at most PAINT_SIDE */
} paint_noise;

typedef struct {
    uint32_t seed;
    float a[3], b[3];               /* the two main colours, sRGB */
    float scale, contrast;
    int count;
    int threads;                    /* of a cloth, along and across */
    paint_noise noise[PAINT_FIELDS];
    const float *field[PAINT_FIELDS];           /* the noises along the row that is being painted */
    float wave[PAINT_SIDE];         /* sine of threads periods */
} paint;

/* The colour at u, v in 0..1, sRGB 0..1; field and wave are filled by then. */
typedef void (*paint_fn)(const paint *p, float u, float v, float rgb[3]);

/* paint_texture - what fn makes of a copy of p, painted by synth_texture_paint; NULL without memory */
synth_texture *paint_texture(lt_arena *arena, const paint *p, paint_fn fn);

/* paint_smooth_noise - in 0..1, repeats after px, py cells, sampled at u, v in 0..1; octaves double the cells and
 * halve the weight */
float paint_smooth_noise(uint32_t seed, float u, float v, int px, int py, int octaves);

/* paint_lattice - a random number in 0..1 for each whole place */
static inline float paint_lattice(uint32_t seed, int x, int y)
{
    uint32_t h = seed ^ (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u;

    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return (float)((h ^ h >> 15) >> 8) / 16777216;
}

/* paint_noise_at - noise `which` in this row at u, which may lie outside 0..1 */
static inline float paint_noise_at(const paint *p, int which, float u)
{
    return p->field[which][floor_int(u * PAINT_SIDE) & (PAINT_SIDE - 1)];
}

/* paint_mix - a + t (b - a); paint_scale - rgb times k; paint_byte - 0..1 as a byte */
static inline void paint_mix(const float a[3], const float b[3], float t, float out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = a[c] + t * (b[c] - a[c]);
}

static inline void paint_scale(float rgb[3], float k)
{
    for (int c = 0; c < 3; c++)
        rgb[c] *= k;
}

static inline uint8_t paint_byte(float x)
{
    return (uint8_t)(255 * within(x, 0, 1) + 0.5f);
}

#endif
