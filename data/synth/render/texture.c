/* SPDX-License-Identifier: Apache-2.0 */
/* Mip chains: far textures are averaged, never picked, so they do not shimmer. */
#include "data/synth/render/texture.h"
#include "data/synth/render/small.h"

#include <string.h>

enum { MAX_LEVELS = 14, MAX_SIDE = 8192, MAX_PROBES = 4, SRGB_STEPS = 4096 };

typedef struct {
    int width, height;
    uint8_t (*texel)[4];            /* sRGB */
} mip;

struct synth_texture {
    int levels;
    mip level[MAX_LEVELS];
};

/* IEC 61966-2-1 */
static double decode(double s) { return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4); }
static double encode(double l) { return l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055; }

static float linear_of[256], srgb_of[SRGB_STEPS + 2];

__attribute__((constructor)) static void make_tables(void)
{
    for (int i = 0; i < 256; i++)
        linear_of[i] = (float)decode(i / 255.0);
    for (int i = 0; i < SRGB_STEPS + 2; i++) {          /* over the root: fine steps in the dark */
        const double root = (double)i / SRGB_STEPS;

        srgb_of[i] = (float)(255 * encode(fmin(root * root, 1)));
    }
}

float srgb_to_linear(uint8_t byte)
{
    return linear_of[byte];
}

float linear_to_srgb(float linear)
{
    const float at = SRGB_STEPS * sqrtf(within(linear, 0, 1));
    const int i = (int)at;

    return srgb_of[i] + (at - (float)i) * (srgb_of[i + 1] - srgb_of[i]);
}

/* Each texel of the next level is the mean light of up to 2 x 2. */
static void halve(const mip *from, mip *to)
{
    for (int y = 0; y < to->height; y++)
        for (int x = 0; x < to->width; x++) {
            const int x0 = 2 * x, x1 = 2 * x + 1 < from->width ? 2 * x + 1 : x0;
            const int y0 = 2 * y, y1 = 2 * y + 1 < from->height ? 2 * y + 1 : y0;

            for (int c = 0; c < 3; c++) {
                const float sum = linear_of[from->texel[y0 * from->width + x0][c]] +
                                  linear_of[from->texel[y0 * from->width + x1][c]] +
                                  linear_of[from->texel[y1 * from->width + x0][c]] +
                                  linear_of[from->texel[y1 * from->width + x1][c]];

                to->texel[y * to->width + x][c] = (uint8_t)(linear_to_srgb(sum / 4) + 0.5f);
            }
        }
}

static bool add_level(lt_arena *arena, synth_texture *t, int width, int height)
{
    mip *m = &t->level[t->levels++];

    m->width = width;
    m->height = height;
    m->texel = lt_arena_array(arena, (size_t)width * (size_t)height, sizeof(*m->texel));
    return m->texel != NULL;
}

synth_texture *synth_texture_new(lt_arena *arena, const uint8_t *rgb, int width, int height)
{
    synth_texture *t;

    if (width < 1 || height < 1 || width > MAX_SIDE || height > MAX_SIDE)
        return NULL;
    t = lt_arena_alloc(arena, sizeof(*t));
    if (!t || !add_level(arena, t, width, height))
        return NULL;
    for (int i = 0; i < width * height; i++)
        memcpy(t->level[0].texel[i], rgb + 3 * i, 3);
    while (width > 1 || height > 1) {
        width = width > 1 ? width / 2 : 1;
        height = height > 1 ? height / 2 : 1;
        if (!add_level(arena, t, width, height))
            return NULL;
        halve(&t->level[t->levels - 2], &t->level[t->levels - 1]);
    }
    return t;
}

static void bilinear(const mip *m, float u, float v, float weight, float rgb[3])
{
    const float x = (u - (float)floor_int(u)) * (float)m->width - 0.5f;        /* -0.5 .. size - 0.5 */
    const float y = (1 - (v - (float)floor_int(v))) * (float)m->height - 0.5f;
    const int ix = floor_int(x), iy = floor_int(y);
    const float fx = x - (float)ix, fy = y - (float)iy;
    const int x0 = ix < 0 ? m->width - 1 : ix, x1 = x0 + 1 < m->width ? x0 + 1 : 0;
    const int y0 = iy < 0 ? m->height - 1 : iy, y1 = y0 + 1 < m->height ? y0 + 1 : 0;
    const uint8_t *a = m->texel[y0 * m->width + x0], *b = m->texel[y0 * m->width + x1];
    const uint8_t *c = m->texel[y1 * m->width + x0], *d = m->texel[y1 * m->width + x1];

    for (int i = 0; i < 3; i++) {
        const float top = linear_of[a[i]] + fx * (linear_of[b[i]] - linear_of[a[i]]);
        const float low = linear_of[c[i]] + fx * (linear_of[d[i]] - linear_of[c[i]]);

        rgb[i] += weight * (top + fy * (low - top));
    }
}

/* A long footprint is covered by up to four probes along it, each as wide as it is narrow. */
void texture_sample(const synth_texture *t, const float uv[2], const float dx[2], const float dy[2],
                    float rgb[3])
{
    const float w = (float)t->level[0].width, h = (float)t->level[0].height;
    const float lx = sqrtf(dx[0] * dx[0] * w * w + dx[1] * dx[1] * h * h);
    const float ly = sqrtf(dy[0] * dy[0] * w * w + dy[1] * dy[1] * h * h);
    const float *axis = lx > ly ? dx : dy;
    const float major = most(most(lx, ly), 1e-6f), minor = most(least(lx, ly), 1e-6f);
    const int probes = (int)least(major / minor + 0.6f, MAX_PROBES);
    const float lod = log2f(most(major / (float)probes, 1));
    const int top = t->levels - 1;
    const int level = lod < (float)top ? (int)lod : top, next = level < top ? level + 1 : top;
    const float mix = least(lod, (float)top) - (float)level;

    rgb[0] = rgb[1] = rgb[2] = 0;
    if (!(fabsf(uv[0]) < 1e6f && fabsf(uv[1]) < 1e6f && lod < 1e6f))
        return;
    for (int i = 0; i < probes; i++) {
        const float s = ((float)i + 0.5f) / (float)probes - 0.5f;
        const float u = uv[0] + s * axis[0], v = uv[1] + s * axis[1];

        bilinear(&t->level[level], u, v, (1 - mix) / (float)probes, rgb);
        if (mix > 0)
            bilinear(&t->level[next], u, v, mix / (float)probes, rgb);
    }
}
