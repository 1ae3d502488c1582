/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "data/synth/room/pattern.h"
#include "data/synth/render/small.h"
#include "libtensor/base/parallel.h"

#include <string.h>

enum { SIDE = 512, LABEL = 256 };

enum { FIELDS = 2 };

/* pattern_noise at every texel: px = 0: none */
typedef struct {
    uint32_t salt;                  /* added to the pattern's seed */
    int px, py, octaves;            /* px << octaves - 1 is at most SIDE */
} noise;

typedef struct {
    uint32_t seed;
    float a[3], b[3];               /* the two main colours, sRGB */
    float scale, contrast;
    int count;
    int threads;                    /* of a cloth, along and across */
    noise noise[FIELDS];
    const float (*field[FIELDS])[SIDE];
    float wave[SIDE];               /* sine of threads periods */
} paint;

typedef void (*paint_fn)(const paint *p, float u, float v, float rgb[3]);

/* ---- noise ----------------------------------------------------------------------------------- */

static float lattice(uint32_t seed, int x, int y)
{
    uint32_t h = seed ^ (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u;

    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return (float)((h ^ h >> 15) >> 8) / 16777216;
}

static float value_noise(uint32_t seed, float u, float v, int px, int py)
{
    const float x = u * (float)px, y = v * (float)py;
    const int ix = (int)x, iy = (int)y;                 /* u, v below 1, or 1 by rounding */
    const int x0 = ix < px ? ix : 0, x1 = x0 + 1 < px ? x0 + 1 : 0;
    const int y0 = iy < py ? iy : 0, y1 = y0 + 1 < py ? y0 + 1 : 0;
    const float fx = x - (float)ix, fy = y - (float)iy;
    const float sx = fx * fx * (3 - 2 * fx), sy = fy * fy * (3 - 2 * fy);
    const float top = lattice(seed, x0, y0) * (1 - sx) + lattice(seed, x1, y0) * sx;
    const float low = lattice(seed, x0, y1) * (1 - sx) + lattice(seed, x1, y1) * sx;

    return top + sy * (low - top);
}

float pattern_noise(uint32_t seed, float u, float v, int px, int py, int octaves)
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
    const float at = ((float)y + 0.5f) / SIDE * (float)py;
    const int y0 = (int)at, y1 = y0 + 1 < py ? y0 + 1 : 0;
    const float fy = at - (float)y0, sy = fy * fy * (3 - 2 * fy);
    float cell[SIDE + 1];

    for (int i = 0; i < px; i++) {
        const float top = lattice(seed, i, y0);

        cell[i] = top + sy * (lattice(seed, i, y1) - top);
    }
    cell[px] = cell[0];
    for (int x = 0; x < SIDE; x++) {
        const float u = ((float)x + 0.5f) / SIDE * (float)px;
        const int i = (int)u;
        const float f = u - (float)i, s = f * f * (3 - 2 * f);

        out[x] += weight * (cell[i] + s * (cell[i + 1] - cell[i]));
    }
}

typedef struct {
    noise noise;
    uint32_t seed;
    float (*out)[SIDE];
} field_job;

static void field_row(void *ctx, int64_t y)
{
    const field_job *job = ctx;
    const noise *n = &job->noise;
    const float first = 1 / (2 - ldexpf(1, 1 - n->octaves));    /* all weights add to 1 */

    memset(job->out[y], 0, sizeof(job->out[y]));
    for (int o = 0; o < n->octaves; o++)
        add_octave(job->seed + n->salt + (uint32_t)o * 0x9e3779b9u, n->px << o, n->py << o, (int)y,
                   ldexpf(first, -o), job->out[y]);
}

/* The noise at the texel of u, v, which may lie outside 0..1. */
static float noise_at(const paint *p, int which, float u, float v)
{
    const int x = floor_int(u * SIDE) & (SIDE - 1), y = floor_int(v * SIDE) & (SIDE - 1);

    return p->field[which][y][x];
}

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

static void mix(const float a[3], const float b[3], float t, float out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = a[c] + t * (b[c] - a[c]);
}

static void scale(float rgb[3], float k)
{
    for (int c = 0; c < 3; c++)
        rgb[c] *= k;
}

static uint8_t to_byte(float x)
{
    return (uint8_t)(255 * within(x, 0, 1) + 0.5f);
}

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

    for (int x = 0; x < SIDE; x++) {
        float c[3];

        job->fn(job->p, ((float)x + 0.5f) / SIDE, ((float)y + 0.5f) / SIDE, c);
        for (int k = 0; k < 3; k++)
            job->rgb[(int)y * SIDE + x][k] = to_byte(c[k]);
    }
}

static bool make_fields(lt_arena *arena, paint *p)
{
    for (int i = 0; i < FIELDS && p->noise[i].px; i++) {
        field_job job = { p->noise[i], p->seed, lt_arena_array(arena, SIDE, sizeof(*job.out)) };

        if (!job.out)
            return false;
        lt_parallel_for(SIDE, field_row, &job);
        p->field[i] = (const float (*)[SIDE])job.out;
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
        p.wave[x] = sinf(6.2831853f * (float)p.threads * ((float)x + 0.5f) / SIDE);
    ok = scratch && make_fields(scratch, &p);
    if (ok)
        lt_parallel_for(side, paint_row, (void *)&job);
    lt_arena_free(scratch);
    return ok;
}

/* Most of what a room has no camera sees, so it is only noted down here. */
static synth_texture *make(lt_arena *arena, const paint *p, paint_fn fn)
{
    recipe *r = lt_arena_alloc(arena, sizeof(*r));

    if (r)
        *r = (recipe){ *p, fn };
    return synth_texture_later(arena, SIDE, follow, r);
}

/* ---- materials ------------------------------------------------------------------------------- */

/* Boards along u, each with its own tone, fibres drawn out along it, and a slow figure of rings. */
static void paint_wood(const paint *p, float u, float v, float rgb[3])
{
    const int boards = p->count, board = (int)(v * (float)boards);
    const float in_board = v * (float)boards - (float)board;
    const float shift = lattice(p->seed, board, 7), tone = lattice(p->seed, board, 8);
    const float bend = noise_at(p, 0, u + shift, v);
    const float rings = 0.5f + 0.5f * sinf(6.2831853f * (in_board * 3 + 4 * bend + shift * 5));
    const float fibre = noise_at(p, 1, u + shift, v);
    const float gap = boards > 1 ? smoothly(0, 0.02f, least(in_board, 1 - in_board)) : 1;

    mix(p->a, p->b, least(0.45f * rings * p->contrast + 0.55f * fibre, 1), rgb);
    scale(rgb, (0.9f + 0.16f * tone) * (0.55f + 0.45f * gap));
}

synth_texture *pattern_wood(lt_arena *arena, lt_rng *r)
{
    static const int boards[4] = { 3, 4, 5, 7 };
    const double dark = lt_rng_range(r, 0.35, 0.95), hue = lt_rng_range(r, 0.055, 0.1);
    paint p = { .seed = lt_rng_u32(r) };

    pattern_hsv(hue, lt_rng_range(r, 0.2, 0.6), dark, p.a);
    pattern_hsv(hue - 0.015, lt_rng_range(r, 0.3, 0.65), 0.78 * dark, p.b);
    p.count = boards[lt_rng_below(r, 4)];
    p.noise[0] = (noise){ 0, 3, 4 * p.count, 2 };
    p.noise[1] = (noise){ 5, 6, 96, 3 };
    p.contrast = (float)lt_rng_range(r, 0.2, 1);
    return make(arena, &p, paint_wood);
}

static void paint_stone(const paint *p, float u, float v, float rgb[3])
{
    const float slow = noise_at(p, 0, u, v);
    const float bent = pattern_noise(p->seed + 9, u + 0.1f * slow, v + 0.1f * slow, 3, 3, 4);
    const float vein = fabsf(bent - 0.5f);
    const float speck = lattice(p->seed, (int)(u * SIDE), (int)(v * SIDE));

    mix(p->a, p->b, p->contrast * (0.5f * slow + 0.6f * (1 - smoothly(0, 0.06f, vein))), rgb);
    scale(rgb, 0.95f + 0.1f * speck * p->scale);
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
    return make(arena, &p, paint_stone);
}

static void paint_plaster(const paint *p, float u, float v, float rgb[3])
{
    const float stain = noise_at(p, 0, u, v), grain = noise_at(p, 1, u, v);

    mix(p->a, p->b, stain, rgb);
    scale(rgb, 1 + p->contrast * (grain - 0.5f));
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
    return make(arena, &p, paint_plaster);
}

/* Threads over and under: a fine brightness pattern. */
static float threads(const paint *p, float u, float v)
{
    return 0.9f + 0.1f * p->wave[(int)(u * SIDE)] * p->wave[(int)(v * SIDE)];
}

static void paint_stripes(const paint *p, float u, float v, float rgb[3])
{
    const float x = u * (float)p->count, in = x - floorf(x);
    const float band = smoothly(0.02f, 0.04f, in) - smoothly(p->scale, p->scale + 0.02f, in);

    mix(p->a, p->b, band, rgb);
    scale(rgb, threads(p, u, v) * (0.9f + 0.2f * noise_at(p, 0, u, v)));
}

static void paint_checks(const paint *p, float u, float v, float rgb[3])
{
    const float x = u * (float)p->count, y = v * (float)p->count;
    const float a = x - floorf(x) < 0.5f, b = y - floorf(y) < 0.5f;

    mix(p->a, p->b, 0.5f * (a + b), rgb);
    scale(rgb, threads(p, u, v) * (0.9f + 0.2f * noise_at(p, 0, u, v)));
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

    return make(arena, &p, paint_stripes);
}

synth_texture *pattern_checks(lt_arena *arena, lt_rng *r)
{
    paint p = cloth_paint(r);

    return make(arena, &p, paint_checks);
}

static void paint_tiles(const paint *p, float u, float v, float rgb[3])
{
    const float x = u * (float)p->count, y = v * (float)p->count;
    const float fx = x - floorf(x), fy = y - floorf(y);
    const float joint = least(least(fx, 1 - fx), least(fy, 1 - fy));
    const float tone = lattice(p->seed, (int)x, (int)y);
    const float dirt = noise_at(p, 0, u, v);

    mix(p->b, p->a, smoothly(0.012f, 0.03f, joint), rgb);
    scale(rgb, 0.9f + 0.1f * tone * p->contrast + 0.08f * dirt);
}

synth_texture *pattern_tiles(lt_arena *arena, lt_rng *r)
{
    const double value = lt_rng_range(r, 0.4, 0.95);
    paint p = { .seed = lt_rng_u32(r), .noise = { { 0, 16, 16, 4 } } };

    p.count = 2 + (int)lt_rng_below(r, 5);
    pattern_draw_color(r, 0, 0.3, value, value, p.a);
    pattern_hsv(0.1, 0.05, value * lt_rng_range(r, 0.5, 0.85), p.b);
    p.contrast = (float)lt_rng_range(r, 0, 2);
    return make(arena, &p, paint_tiles);
}

static void paint_weave(const paint *p, float u, float v, float rgb[3])
{
    memcpy(rgb, p->a, sizeof(p->a));
    scale(rgb, threads(p, u, v) * (0.82f + 0.36f * noise_at(p, 0, u, v)));
}

synth_texture *pattern_weave(lt_arena *arena, lt_rng *r, const float rgb[3])
{
    paint p = { .seed = lt_rng_u32(r), .threads = 96, .noise = { { 0, 6, 6, 6 } } };

    memcpy(p.a, rgb, sizeof(p.a));
    return make(arena, &p, paint_weave);
}

static void paint_fruit(const paint *p, float u, float v, float rgb[3])
{
    const float blush = noise_at(p, 0, u, v), streak = noise_at(p, 1, u, v);
    const float dot = lattice(p->seed, (int)(u * 90), (int)(v * 60)) > 0.96f ? 0.12f : 0;

    mix(p->a, p->b, smoothly(0.3f, 0.7f, 0.7f * blush + 0.3f * streak), rgb);
    scale(rgb, 0.94f + 0.1f * streak + dot);
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
    return make(arena, &p, paint_fruit);
}

/* ---- print ----------------------------------------------------------------------------------- */

typedef struct { uint8_t px[LABEL][LABEL][3]; } canvas;

/* A filled rectangle or, round, the ellipse in it. */
static void fill(canvas *c, int x0, int y0, int x1, int y1, const float rgb[3], bool round)
{
    const float mx = (float)(x0 + x1) / 2, my = (float)(y0 + y1) / 2;
    const float rx = most((float)(x1 - x0) / 2, 0.5f), ry = most((float)(y1 - y0) / 2, 0.5f);

    for (int y = y0 < 0 ? 0 : y0; y < y1 && y < LABEL; y++)
        for (int x = x0 < 0 ? 0 : x0; x < x1 && x < LABEL; x++) {
            const float dx = ((float)x + 0.5f - mx) / rx, dy = ((float)y + 0.5f - my) / ry;

            for (int k = 0; k < 3 && !(round && dx * dx + dy * dy > 1); k++)
                c->px[y][x][k] = to_byte(rgb[k]);
        }
}

/* A line of glyph-like blobs: strokes and bowls in cells, gaps between words. */
static void print_line(canvas *c, lt_rng *r, int x, int y, int width, int height,
                       const float rgb[3])
{
    const int end = x + width, stroke = height > 7 ? height / 4 : 1;

    while (x + height / 2 < end) {
        const int w = height / 2 + (int)lt_rng_below(r, 2);

        if (lt_rng_below(r, 6) > 0) {
            const uint32_t shape = lt_rng_u32(r);

            if (shape & 1)
                fill(c, x, y, x + stroke, y + height, rgb, false);
            if (shape & 2)
                fill(c, x + w - stroke, y, x + w, y + height, rgb, false);
            if (shape & 4 || !(shape & 3))
                fill(c, x, y, x + w, y + stroke, rgb, false);
            if (shape & 8)
                fill(c, x, y + height / 2, x + w, y + height / 2 + stroke, rgb, false);
            if (shape & 16)
                fill(c, x, y + height - stroke, x + w, y + height, rgb, false);
        }
        x += w + (stroke > 1 ? stroke : 1);
    }
}

static void print_text(canvas *c, lt_rng *r, int x, int y, int width, int lines, const float rgb[3])
{
    for (int i = 0; i < lines; i++) {
        const int used = (int)(width * lt_rng_range(r, 0.6, 1));

        print_line(c, r, x, y + 7 * i, used, 4, rgb);
    }
}

static void print_bars(canvas *c, lt_rng *r, int x, int y)
{
    const float white[3] = { 0.95f, 0.95f, 0.95f }, black[3] = { 0.05f, 0.05f, 0.05f };

    fill(c, x, y, x + 42, y + 26, white, false);
    for (int i = 3; i < 38; i += 2 + (int)lt_rng_below(r, 3))       /* the step is drawn after the bar */
        fill(c, x + i, y + 3, x + i + 1 + (int)lt_rng_below(r, 2), y + 22, black, false);
}

static void label_colors(lt_rng *r, float base[3], float panel[3], float ink[3])
{
    const double value = lt_rng_range(r, 0.25, 0.95), ink_value = value > 0.6 ? 0.18 : 0.92;
    const bool grey = lt_rng_below(r, 4) == 0;

    pattern_draw_color(r, grey ? 0 : 0.25, grey ? 0.1 : 0.8, value, value, base);
    pattern_draw_color(r, 0, 0.6, 0.6, 0.95, panel);
    pattern_draw_color(r, 0, 0.5, ink_value, ink_value, ink);
}

/* One quarter of a label: a panel, a title, a picture, fine print. */
static void print_quarter(canvas *c, lt_rng *r, int x, int y, const float panel[3],
                          const float ink[3])
{
    const int h = LABEL / 2, top = y + (int)lt_rng_below(r, 30);
    const int low = top + 30 + (int)lt_rng_below(r, 60), title = 14 + (int)lt_rng_below(r, 12);
    const int right = x + 60 + (int)lt_rng_below(r, 40), below = y + 92 + (int)lt_rng_below(r, 30);
    const bool has_panel = lt_rng_below(r, 3) > 0, round = lt_rng_below(r, 4) == 0;
    const bool has_picture = lt_rng_below(r, 2), has_bars = lt_rng_below(r, 3) == 0;
    float picture[3];

    pattern_draw_color(r, 0.3, 0.9, 0.4, 0.95, picture);
    if (has_panel)
        fill(c, x + 6, top, x + h - 6, low, panel, round);
    print_line(c, r, x + 12, top + 8, h - 30, title, ink);
    if (has_picture)
        fill(c, x + 30, y + 70, right, below, picture, true);
    print_text(c, r, x + 14, y + 100, h - 28, 3, ink);
    if (has_bars)
        print_bars(c, r, x + h - 50, y + h - 34);
}

synth_texture *pattern_label(lt_arena *arena, lt_rng *r)
{
    canvas *c = lt_alloc(sizeof(*c));
    float base[3], panel[3], ink[3];
    synth_texture *t;

    if (!c)
        return NULL;
    label_colors(r, base, panel, ink);
    fill(c, 0, 0, LABEL, LABEL, base, false);
    if (lt_rng_below(r, 2)) {
        const int y = (int)lt_rng_below(r, LABEL / 2 - 20), h = 6 + (int)lt_rng_below(r, 30);

        fill(c, 0, y, LABEL, y + h, panel, false);
        fill(c, 0, y + LABEL / 2, LABEL, y + h + LABEL / 2, panel, false);
    }
    for (int q = 0; q < 4; q++)
        print_quarter(c, r, q % 2 * LABEL / 2, q / 2 * LABEL / 2, panel, ink);
    t = synth_texture_new(arena, c->px[0][0], LABEL, LABEL);
    lt_release(c);
    return t;
}

/* A sheet of paper with a heading, paragraphs and now and then a picture. */
synth_texture *pattern_page(lt_arena *arena, lt_rng *r)
{
    const float white[3] = { 0.95f, 0.94f, 0.91f }, black[3] = { 0.15f, 0.15f, 0.18f };
    canvas *c = lt_alloc(sizeof(*c));
    float picture[3];
    synth_texture *t;

    if (!c)
        return NULL;
    fill(c, 0, 0, LABEL, LABEL, white, false);
    print_line(c, r, 24, 18, 170, 12, black);
    print_text(c, r, 24, 44, 208, 24, black);
    if (lt_rng_below(r, 2)) {
        const int y = 60 + (int)lt_rng_below(r, 90);

        pattern_draw_color(r, 0.1, 0.7, 0.4, 0.9, picture);
        fill(c, 24, y, 230, y + 70, picture, false);
    }
    t = synth_texture_new(arena, c->px[0][0], LABEL, LABEL);
    lt_release(c);
    return t;
}
