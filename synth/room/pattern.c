/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/render/small.h"
#include "synth/room/paint.h"
#include "synth/room/pattern.h"

#include <string.h>

/* ---- colours --------------------------------------------------------------------------------- */

void pattern_hsv(double hue, double saturation, double value, float rgb[3])
{
    for (int c = 0; c < 3; c++) {
        const double k = fmod(hue * 6 + (c == 0 ? 5 : c == 1 ? 3 : 1), 6);

        rgb[c] = (float)(value * (1 - saturation * fmax(0, fmin(fmin(k, 4 - k), 1))));
    }
}

void pattern_draw_color(lt_rng *r, double saturation_lo, double saturation_hi, double value_lo,
                        double value_hi, float rgb[3])
{
    const double hue = lt_rng_uniform(r);
    const double saturation = lt_rng_range(r, saturation_lo, saturation_hi);
    const double value = lt_rng_range(r, value_lo, value_hi);

    pattern_hsv(hue, saturation, value, rgb);
}

/* ---- materials ------------------------------------------------------------------------------- */

/* Boards along u, each with its own tone, fibres drawn out along it, and a slow figure of rings. */
static void paint_wood(const paint *p, float u, float v, float rgb[3])
{
    const int boards = p->count, board = (int)(v * (float)boards);
    const float in_board = v * (float)boards - (float)board;
    const float shift = paint_lattice(p->seed, board, 7), tone = paint_lattice(p->seed, board, 8);
    const float bend = paint_noise_at(p, 0, u + shift);
    const float rings = 0.5f + 0.5f * sinf(6.2831853f * (in_board * 3 + 4 * bend + shift * 5));
    const float fibre = paint_noise_at(p, 1, u + shift);
    const float gap = boards > 1 ? smoothly(0, 0.02f, least(in_board, 1 - in_board)) : 1;

    paint_mix(p->a, p->b, least(0.45f * rings * p->contrast + 0.55f * fibre, 1), rgb);
    paint_scale(rgb, (0.9f + 0.16f * tone) * (0.55f + 0.45f * gap));
}

synth_texture *pattern_wood(lt_arena *arena, lt_rng *r)
{
    static const int boards[4] = { 3, 4, 5, 7 };
    const double dark = lt_rng_range(r, 0.35, 0.95), hue = lt_rng_range(r, 0.055, 0.1);
    paint p = { .seed = lt_rng_u32(r) };

    pattern_hsv(hue, lt_rng_range(r, 0.2, 0.6), dark, p.a);
    pattern_hsv(hue - 0.015, lt_rng_range(r, 0.3, 0.65), 0.78 * dark, p.b);
    p.count = boards[lt_rng_below(r, 4)];
    p.noise[0] = (paint_noise){ 0, 3, 4 * p.count, 2 };
    p.noise[1] = (paint_noise){ 5, 6, 96, 3 };
    p.contrast = (float)lt_rng_range(r, 0.2, 1);
    return paint_texture(arena, &p, paint_wood);
}

static void paint_stone(const paint *p, float u, float v, float rgb[3])
{
    const float slow = paint_noise_at(p, 0, u);
    const float bent = paint_smooth_noise(p->seed + 9, u + 0.1f * slow, v + 0.1f * slow, 3, 3, 4);
    const float vein = fabsf(bent - 0.5f);
    const float speck = paint_lattice(p->seed, (int)(u * PAINT_SIDE), (int)(v * PAINT_SIDE));

    paint_mix(p->a, p->b, p->contrast * (0.5f * slow + 0.6f * (1 - smoothly(0, 0.06f, vein))), rgb);
    paint_scale(rgb, 0.95f + 0.1f * speck * p->scale);
}

synth_texture *pattern_stone(lt_arena *arena, lt_rng *r)
{
    const double value = lt_rng_range(r, 0.25, 0.95), hue = lt_rng_uniform(r);
    const double darker = value * lt_rng_range(r, 0.5, 0.9);
    paint p = { .seed = lt_rng_u32(r), .noise = { { 0, 4, 4, 5 } } };

    pattern_hsv(hue, lt_rng_range(r, 0, 0.15), value, p.a);
    pattern_hsv(hue, lt_rng_range(r, 0, 0.2), darker, p.b);
    p.contrast = (float)lt_rng_range(r, 0.1, 1);
    p.scale = (float)lt_rng_range(r, 0, 2);
    return paint_texture(arena, &p, paint_stone);
}

static void paint_plaster(const paint *p, float u, float v, float rgb[3])
{
    const float stain = paint_noise_at(p, 0, u), grain = paint_noise_at(p, 1, u);

    (void)v;
    paint_mix(p->a, p->b, stain, rgb);
    paint_scale(rgb, 1 + p->contrast * (grain - 0.5f));
}

synth_texture *pattern_plaster(lt_arena *arena, lt_rng *r)
{
    const double value = lt_rng_range(r, 0.45, 0.97), hue = lt_rng_uniform(r);
    const bool pale = lt_rng_below(r, 3) > 0;
    const double saturation = pale ? lt_rng_range(r, 0, 0.12) : lt_rng_range(r, 0.1, 0.45);
    paint p = { .seed = lt_rng_u32(r), .noise = { { 0, 2, 2, 3 }, { 3, 64, 64, 3 } } };

    p.contrast = (float)lt_rng_range(r, 0.05, 0.25);
    pattern_hsv(hue, saturation, value, p.a);
    pattern_hsv(hue, saturation, 0.88 * value, p.b);
    return paint_texture(arena, &p, paint_plaster);
}

/* Threads over and under: a fine brightness pattern. */
static float threads(const paint *p, float u, float v)
{
    return 0.9f + 0.1f * p->wave[(int)(u * PAINT_SIDE)] * p->wave[(int)(v * PAINT_SIDE)];
}

static void paint_stripes(const paint *p, float u, float v, float rgb[3])
{
    const float x = u * (float)p->count, in = x - floorf(x);
    const float band = smoothly(0.02f, 0.04f, in) - smoothly(p->scale, p->scale + 0.02f, in);

    paint_mix(p->a, p->b, band, rgb);
    paint_scale(rgb, threads(p, u, v) * (0.9f + 0.2f * paint_noise_at(p, 0, u)));
}

static void paint_checks(const paint *p, float u, float v, float rgb[3])
{
    const float x = u * (float)p->count, y = v * (float)p->count;
    const float a = x - floorf(x) < 0.5f, b = y - floorf(y) < 0.5f;

    paint_mix(p->a, p->b, 0.5f * (a + b), rgb);
    paint_scale(rgb, threads(p, u, v) * (0.9f + 0.2f * paint_noise_at(p, 0, u)));
}

static paint cloth_paint(lt_rng *r)
{
    paint p = { .seed = lt_rng_u32(r), .threads = 128, .noise = { { 0, 8, 8, 4 } } };

    p.count = 4 + (int)lt_rng_below(r, 10);
    p.scale = (float)lt_rng_range(r, 0.2, 0.7);
    pattern_draw_color(r, 0, 0.25, 0.7, 0.97, p.a);
    pattern_draw_color(r, 0.1, 0.7, 0.2, 0.8, p.b);
    return p;
}

synth_texture *pattern_stripes(lt_arena *arena, lt_rng *r)
{
    paint p = cloth_paint(r);

    return paint_texture(arena, &p, paint_stripes);
}

synth_texture *pattern_checks(lt_arena *arena, lt_rng *r)
{
    paint p = cloth_paint(r);

    return paint_texture(arena, &p, paint_checks);
}

static void paint_tiles(const paint *p, float u, float v, float rgb[3])
{
    const float x = u * (float)p->count, y = v * (float)p->count;
    const float fx = x - floorf(x), fy = y - floorf(y);
    const float joint = least(least(fx, 1 - fx), least(fy, 1 - fy));
    const float tone = paint_lattice(p->seed, (int)x, (int)y);
    const float dirt = paint_noise_at(p, 0, u);

    paint_mix(p->b, p->a, smoothly(0.012f, 0.03f, joint), rgb);
    paint_scale(rgb, 0.9f + 0.1f * tone * p->contrast + 0.08f * dirt);
}

synth_texture *pattern_tiles(lt_arena *arena, lt_rng *r)
{
    const double value = lt_rng_range(r, 0.4, 0.95);
    paint p = { .seed = lt_rng_u32(r), .noise = { { 0, 16, 16, 4 } } };

    p.count = 2 + (int)lt_rng_below(r, 5);
    pattern_draw_color(r, 0, 0.3, value, value, p.a);
    pattern_hsv(0.1, 0.05, value * lt_rng_range(r, 0.5, 0.85), p.b);
    p.contrast = (float)lt_rng_range(r, 0, 2);
    return paint_texture(arena, &p, paint_tiles);
}

static void paint_weave(const paint *p, float u, float v, float rgb[3])
{
    memcpy(rgb, p->a, sizeof(p->a));
    paint_scale(rgb, threads(p, u, v) * (0.82f + 0.36f * paint_noise_at(p, 0, u)));
}

synth_texture *pattern_weave(lt_arena *arena, lt_rng *r, const float rgb[3])
{
    paint p = { .seed = lt_rng_u32(r), .threads = 96, .noise = { { 0, 6, 6, 6 } } };

    memcpy(p.a, rgb, sizeof(p.a));
    return paint_texture(arena, &p, paint_weave);
}

static void paint_fruit(const paint *p, float u, float v, float rgb[3])
{
    const float blush = paint_noise_at(p, 0, u), streak = paint_noise_at(p, 1, u);
    const float dot = paint_lattice(p->seed, (int)(u * 90), (int)(v * 60)) > 0.96f ? 0.12f : 0;

    paint_mix(p->a, p->b, smoothly(0.3f, 0.7f, 0.7f * blush + 0.3f * streak), rgb);
    paint_scale(rgb, 0.94f + 0.1f * streak + dot);
}

synth_texture *pattern_fruit(lt_arena *arena, lt_rng *r)
{
    static const float hues[5][2] = {
        { 0.99f, 0.12f }, { 0.075f, 0.09f }, { 0.15f, 0.17f }, { 0.24f, 0.27f }, { 0.97f, 0.04f },
    };
    const float *hue = hues[lt_rng_below(r, 5)];
    paint p = { .seed = lt_rng_u32(r), .noise = { { 0, 3, 2, 3 }, { 1, 40, 3, 2 } } };

    pattern_hsv(hue[0], 0.82, lt_rng_range(r, 0.6, 0.9), p.a);
    pattern_hsv(hue[1], 0.75, lt_rng_range(r, 0.65, 0.95), p.b);
    return paint_texture(arena, &p, paint_fruit);
}
