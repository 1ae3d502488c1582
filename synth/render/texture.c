/* SPDX-License-Identifier: Apache-2.0 */
/* Mip chains: far textures are averaged, never picked, so they do not shimmer. */
#include "synth/render/small.h"
#include "synth/render/texture.h"

#include <assert.h>
#include <string.h>

enum { MAX_LEVELS = 14, MAX_SIDE = 8192, MAX_PROBES = 4, SRGB_STEPS = 4096 };

/* Halfwords before zeros: whole numbers. */
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define WIDEN 0, 8, 1, 9, 2, 10, 3, 11
#else
#define WIDEN 8, 0, 9, 1, 10, 2, 11, 3
#endif

typedef uint16_t texel[4];          /* linear, 65535 is 1 */

typedef struct {
    int width, height;
    texel *texel;
} mip;

struct synth_texture {
    int levels;                     /* 0: not painted yet */
    mip level[MAX_LEVELS];
    lt_arena *arena;
    int side;                       /* of what paint makes of the recipe */
    synth_paint_fn paint;
    const void *recipe;
};

/* IEC 61966-2-1 */
static double decode(double s) { return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4); }
static double encode(double l) { return l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055; }

static float srgb_of[SRGB_STEPS + 2];
static uint16_t texel_of[256];

__attribute__((constructor)) static void make_tables(void)
{
    for (int i = 0; i < 256; i++)
        texel_of[i] = (uint16_t)lrint(65535 * decode(i / 255.0));
    for (int i = 0; i < SRGB_STEPS + 2; i++) {          /* over the root: fine steps in the dark */
        const double root = (double)i / SRGB_STEPS;

        srgb_of[i] = (float)(255 * encode(fmin(root * root, 1)));
    }
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

            for (int c = 0; c < 3; c++)
                to->texel[y * to->width + x][c] = (uint16_t)((from->texel[y0 * from->width + x0][c] +
                                                              from->texel[y0 * from->width + x1][c] +
                                                              from->texel[y1 * from->width + x0][c] +
                                                              from->texel[y1 * from->width + x1][c] + 2) / 4);
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

static void set_row(const mip *m, int y, const uint8_t (*rgb)[3])
{
    for (int x = 0; x < m->width; x++)
        for (int c = 0; c < 3; c++)
            m->texel[y * m->width + x][c] = texel_of[rgb[x][c]];
}

/* The levels below the first. */
static bool add_halves(lt_arena *arena, synth_texture *t)
{
    int width = t->level[0].width, height = t->level[0].height;

    while (width > 1 || height > 1) {
        width = width > 1 ? width / 2 : 1;
        height = height > 1 ? height / 2 : 1;
        if (!add_level(arena, t, width, height))
            return false;
        halve(&t->level[t->levels - 2], &t->level[t->levels - 1]);
    }
    return true;
}

synth_texture *synth_texture_new(lt_arena *arena, const uint8_t *rgb, int width, int height)
{
    synth_texture *t;

    if (width < 1 || height < 1 || width > MAX_SIDE || height > MAX_SIDE)
        return NULL;
    t = lt_arena_alloc(arena, sizeof(*t));
    if (!t || !add_level(arena, t, width, height))
        return NULL;
    for (int y = 0; y < height; y++)
        set_row(&t->level[0], y, (const uint8_t (*)[3])rgb + (size_t)y * (size_t)width);
    return add_halves(arena, t) ? t : NULL;
}

synth_texture *synth_texture_later(lt_arena *arena, int side, synth_paint_fn paint, const void *recipe)
{
    synth_texture *t = side > 0 && side <= MAX_SIDE ? lt_arena_alloc(arena, sizeof(*t)) : NULL;

    if (t)
        *t = (synth_texture){ .arena = arena, .side = side, .paint = paint, .recipe = recipe };
    return t;
}

bool synth_texture_paint(synth_texture *t)
{
    uint8_t row[MAX_SIDE][3];

    if (t->levels)
        return true;
    if (!add_level(t->arena, t, t->side, t->side))
        return false;
    for (int y = 0; y < t->side; y++) {
        t->paint(t->recipe, t->side, y, row);
        set_row(&t->level[0], y, (const uint8_t (*)[3])row);
    }
    return add_halves(t->arena, t);
}

/* A texel as floats. */
static v4 fetch(const mip *m, int x, int y)
{
    typedef uint64_t u64x2 __attribute__((vector_size(16)));
    typedef uint16_t u16x8 __attribute__((vector_size(16)));
    uint64_t t;

    memcpy(&t, m->texel[y * m->width + x], sizeof(t));
    return __builtin_convertvector((i32x4)__builtin_shufflevector((u16x8)(u64x2){ t, 0 }, (u16x8){ 0 }, WIDEN),
                                   v4);
}

/* The colour at u, v, 65535 being 1. */
static v4 bilinear(const mip *m, float u, float v)
{
    const float x = (u - (float)floor_int(u)) * (float)m->width - 0.5f;        /* -0.5 .. size - 0.5 */
    const float y = (1 - (v - (float)floor_int(v))) * (float)m->height - 0.5f;
    const int ix = floor_int(x), iy = floor_int(y);
    const v4 fx = v4_all(x - (float)ix), fy = v4_all(y - (float)iy);
    const int x0 = ix < 0 ? m->width - 1 : ix, x1 = x0 + 1 < m->width ? x0 + 1 : 0;
    const int y0 = iy < 0 ? m->height - 1 : iy, y1 = y0 + 1 < m->height ? y0 + 1 : 0;
    const v4 a = fetch(m, x0, y0), c = fetch(m, x0, y1);
    const v4 top = a + fx * (fetch(m, x1, y0) - a), low = c + fx * (fetch(m, x1, y1) - c);

    return top + fy * (low - top);
}

/* A long footprint is covered by up to four probes along it, each as wide as it is narrow. Between two
 * levels only the middle half is blended: the ends are near enough to one of them. */
texture_footprint texture_cover(const synth_texture *t, v4 dx, v4 dy)
{
    const float w = (float)t->level[0].width, h = (float)t->level[0].height;
    const float x2 = dx[0] * dx[0] * w * w + dx[1] * dx[1] * h * h;
    const float y2 = dy[0] * dy[0] * w * w + dy[1] * dy[1] * h * h;
    const float major = most(most(x2, y2), 1e-12f), minor = most(least(x2, y2), 1e-12f);
    const int probes = (int)least(sqrtf(major / minor) + 0.4f, MAX_PROBES), top = t->levels - 1;
    const float lod = 0.5f * log2f(most(major / (float)(probes * probes), 1));
    texture_footprint f = { .axis = x2 > y2 ? dx : dy };

    assert(t->levels);              /* synth_texture_paint */
    if (!(lod < 1e6f))
        return f;
    f.probes = probes;
    f.level = lod < (float)top ? (int)lod : top;
    f.next = f.level < top ? f.level + 1 : top;
    f.mix = within(2 * (least(lod, (float)top) - (float)f.level) - 0.5f, 0, 1);
    return f;
}

v4 texture_sample(const synth_texture *t, v4 uv, const texture_footprint *f)
{
    v4 sum = v4_all(0);

    if (!(f->probes && fabsf(uv[0]) < 1e6f && fabsf(uv[1]) < 1e6f))
        return sum;
    for (int i = 0; i < f->probes; i++) {
        const float s = ((float)i + 0.5f) / (float)f->probes - 0.5f;
        const float u = uv[0] + s * f->axis[0], v = uv[1] + s * f->axis[1];

        if (f->mix < 1)
            sum += v4_all(1 - f->mix) * bilinear(&t->level[f->level], u, v);
        if (f->mix > 0)
            sum += v4_all(f->mix) * bilinear(&t->level[f->next], u, v);
    }
    return sum * v4_all(1 / (65535 * (float)f->probes));
}
