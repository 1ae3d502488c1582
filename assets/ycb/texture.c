/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Labels of the stand-in objects: panels, stripes, brand blocks, text-like print, barcodes.
 */
#include "assets/ycb/objects.h"

#include "assets/ycb/solid.h"
#include "libtensor/base/rng.h"

#include <math.h>

enum { SIZE = SYNTH_TEXTURE };

static const uint64_t PRINT = 0x3ebd25666fd8d71f;       /* any: an object looks the same in every dataset */

typedef struct { uint8_t rgb[3]; } color;
typedef struct { double x0, y0, x1, y1; } rect;         /* pixels, y down */

typedef enum { CARTON, CAN, BOTTLE, PLAIN, WOOD, BANANA } print_kind;

/* What an object is printed in. second and third colour its other parts: caps, handles, insides. */
typedef struct {
    print_kind kind;
    color base, panel, accent, ink, top, second, third;
} recipe;

static const recipe recipes[SYNTH_OBJECTS] = {
    { CAN, {{ 22, 48, 110 }}, {{ 232, 232, 226 }}, {{ 190, 150, 60 }}, {{ 20, 24, 40 }},
      {{ 196, 198, 200 }}, {{ 60, 60, 60 }}, {{ 60, 60, 60 }} },
    { CARTON, {{ 178, 28, 34 }}, {{ 240, 226, 190 }}, {{ 226, 168, 50 }}, {{ 40, 24, 20 }},
      {{ 168, 24, 32 }}, {{ 60, 60, 60 }}, {{ 60, 60, 60 }} },
    { CARTON, {{ 240, 206, 40 }}, {{ 246, 244, 236 }}, {{ 30, 70, 160 }}, {{ 24, 30, 70 }},
      {{ 236, 200, 40 }}, {{ 60, 60, 60 }}, {{ 60, 60, 60 }} },
    { CAN, {{ 186, 24, 30 }}, {{ 244, 240, 230 }}, {{ 200, 160, 60 }}, {{ 40, 20, 20 }},
      {{ 198, 198, 200 }}, {{ 60, 60, 60 }}, {{ 60, 60, 60 }} },
    { BOTTLE, {{ 244, 196, 16 }}, {{ 252, 222, 60 }}, {{ 190, 24, 30 }}, {{ 30, 50, 130 }},
      {{ 238, 190, 16 }}, {{ 238, 182, 20 }}, {{ 200, 40, 30 }} },
    { CAN, {{ 30, 90, 170 }}, {{ 120, 200, 226 }}, {{ 240, 240, 240 }}, {{ 16, 30, 80 }},
      {{ 200, 202, 204 }}, {{ 60, 60, 60 }}, {{ 60, 60, 60 }} },
    { CARTON, {{ 92, 52, 34 }}, {{ 222, 190, 150 }}, {{ 190, 30, 36 }}, {{ 250, 244, 230 }},
      {{ 98, 56, 36 }}, {{ 60, 60, 60 }}, {{ 60, 60, 60 }} },
    { CARTON, {{ 190, 26, 42 }}, {{ 246, 236, 232 }}, {{ 240, 110, 130 }}, {{ 60, 16, 24 }},
      {{ 196, 30, 48 }}, {{ 60, 60, 60 }}, {{ 60, 60, 60 }} },
    { CAN, {{ 26, 56, 140 }}, {{ 240, 214, 70 }}, {{ 206, 90, 80 }}, {{ 250, 248, 240 }},
      {{ 190, 192, 196 }}, {{ 60, 60, 60 }}, {{ 60, 60, 60 }} },
    { BANANA, {{ 240, 204, 60 }}, {{ 196, 178, 60 }}, {{ 90, 66, 30 }}, {{ 30, 60, 140 }},
      {{ 240, 204, 60 }}, {{ 120, 96, 40 }}, {{ 120, 96, 40 }} },
    { PLAIN, {{ 34, 72, 164 }}, {{ 44, 84, 178 }}, {{ 28, 62, 146 }}, {{ 210, 216, 230 }},
      {{ 30, 64, 150 }}, {{ 36, 76, 170 }}, {{ 30, 64, 150 }} },
    { BOTTLE, {{ 238, 238, 236 }}, {{ 40, 84, 176 }}, {{ 226, 190, 40 }}, {{ 20, 40, 110 }},
      {{ 232, 232, 230 }}, {{ 44, 90, 180 }}, {{ 60, 60, 60 }} },
    { WOOD, {{ 186, 34, 38 }}, {{ 186, 34, 38 }}, {{ 186, 34, 38 }}, {{ 186, 34, 38 }},
      {{ 178, 32, 36 }}, {{ 186, 34, 38 }}, {{ 190, 36, 40 }} },
    { PLAIN, {{ 188, 30, 36 }}, {{ 196, 36, 42 }}, {{ 176, 26, 32 }}, {{ 240, 232, 226 }},
      {{ 180, 28, 34 }}, {{ 190, 30, 36 }}, {{ 198, 40, 44 }} },
    { PLAIN, {{ 226, 104, 24 }}, {{ 30, 30, 32 }}, {{ 236, 120, 36 }}, {{ 20, 20, 22 }},
      {{ 30, 30, 32 }}, {{ 36, 36, 38 }}, {{ 160, 162, 166 }} },
    { WOOD, {{ 186, 138, 86 }}, {{ 160, 112, 64 }}, {{ 204, 158, 106 }}, {{ 140, 96, 54 }},
      {{ 190, 144, 92 }}, {{ 60, 60, 60 }}, {{ 60, 60, 60 }} },
    { PLAIN, {{ 232, 112, 26 }}, {{ 232, 112, 26 }}, {{ 216, 100, 20 }}, {{ 40, 40, 42 }},
      {{ 232, 112, 26 }}, {{ 90, 92, 96 }}, {{ 176, 178, 184 }} },
    { CAN, {{ 240, 240, 238 }}, {{ 240, 240, 238 }}, {{ 30, 30, 32 }}, {{ 24, 24, 26 }},
      {{ 30, 30, 32 }}, {{ 28, 28, 30 }}, {{ 28, 28, 30 }} },
    { WOOD, {{ 34, 34, 36 }}, {{ 34, 34, 36 }}, {{ 34, 34, 36 }}, {{ 34, 34, 36 }},
      {{ 34, 34, 36 }}, {{ 214, 100, 34 }}, {{ 120, 122, 126 }} },
    { WOOD, {{ 34, 34, 36 }}, {{ 34, 34, 36 }}, {{ 34, 34, 36 }}, {{ 34, 34, 36 }},
      {{ 34, 34, 36 }}, {{ 214, 100, 34 }}, {{ 120, 122, 126 }} },
    { WOOD, {{ 200, 60, 74 }}, {{ 200, 60, 74 }}, {{ 200, 60, 74 }}, {{ 200, 60, 74 }},
      {{ 200, 60, 74 }}, {{ 200, 60, 74 }}, {{ 200, 60, 74 }} },
    { PLAIN, {{ 222, 214, 196 }}, {{ 86, 116, 112 }}, {{ 212, 202, 182 }}, {{ 70, 96, 94 }},
      {{ 218, 210, 192 }}, {{ 206, 196, 176 }}, {{ 150, 120, 90 }} },
};

typedef struct {
    uint8_t (*px)[3];
    lt_rng rng;
    const recipe *ink;
} canvas;

/* ---- marks ---------------------------------------------------------------------------------------- */

static void put(canvas *c, int x, int y, color k)
{
    if (x < 0 || x >= SIZE || y < 0 || y >= SIZE)
        return;
    for (int i = 0; i < 3; i++)
        c->px[(size_t)y * SIZE + x][i] = k.rgb[i];
}

static void fill(canvas *c, rect r, color k)
{
    for (int y = (int)lround(r.y0); y < lround(r.y1); y++)
        for (int x = (int)lround(r.x0); x < lround(r.x1); x++)
            put(c, x, y, k);
}

static void ellipse(canvas *c, rect r, color k)
{
    const double cx = (r.x0 + r.x1) / 2, cy = (r.y0 + r.y1) / 2;
    const double w = (r.x1 - r.x0) / 2, h = (r.y1 - r.y0) / 2;

    for (int y = (int)r.y0; y < r.y1; y++)
        for (int x = (int)r.x0; x < r.x1; x++)
            if (pow((x + 0.5 - cx) / w, 2) + pow((y + 0.5 - cy) / h, 2) < 1)
                put(c, x, y, k);
}

/* The part of r between the shares fx0..fx1 of its width and fy0..fy1 of its height. */
static rect part(rect r, double fx0, double fy0, double fx1, double fy1)
{
    const double w = r.x1 - r.x0, h = r.y1 - r.y0;

    return (rect){ r.x0 + fx0 * w, r.y0 + fy0 * h, r.x0 + fx1 * w, r.y0 + fy1 * h };
}

/* One letter, 3 x 5 cells, its top row in the highest bits. */
static void glyph(canvas *c, rect r, color k)
{
    static const uint16_t bits[] = {
        0x2bed, 0x3923, 0x79a7, 0x5bed, 0x7497, 0x4927, 0x2b6a, 0x6bad, 0x388e, 0x7492, 0x5b6f, 0x7b6d,
    };
    const uint16_t b = bits[lt_rng_below(&c->rng, LT_COUNT(bits))];

    for (int i = 0; i < 15; i++)
        if (b >> (14 - i) & 1)
            fill(c, part(r, i % 3 / 3.0, i / 3 / 5.0, (i % 3 + 1) / 3.0, (i / 3 + 1) / 5.0), k);
}

/* A line of n letters filling r. */
static void word(canvas *c, rect r, int n, color k)
{
    for (int i = 0; i < n; i++)
        glyph(c, part(r, (i + 0.08) / n, 0, (i + 0.86) / n, 1), k);
}

/* Lines of small print with ragged ends. */
static void print_lines(canvas *c, rect r, double height, color k)
{
    for (double y = r.y0; y + height <= r.y1; y += 1.7 * height) {
        const double end = r.x0 + (r.x1 - r.x0) * lt_rng_range(&c->rng, 0.55, 1);
        for (double x = r.x0, w; x < end; x += w + height) {
            w = height * lt_rng_range(&c->rng, 1.5, 5);
            word(c, (rect){ x, y, fmin(x + w, r.x1), y + height }, (int)(w / (0.8 * height)) + 1, k);
        }
    }
}

static void barcode(canvas *c, rect r)
{
    const color white = {{ 250, 250, 250 }}, black = {{ 10, 10, 10 }};

    fill(c, r, white);
    r = part(r, 0.08, 0.08, 0.92, 0.8);
    for (double x = r.x0, w; x < r.x1; x += w + 1 + lt_rng_below(&c->rng, 2)) {
        w = 1 + lt_rng_below(&c->rng, 3);
        fill(c, (rect){ x, r.y0, fmin(x + w, r.x1), r.y1 }, black);
    }
}

static void stripes(canvas *c, rect r, int n, color k)
{
    for (int i = 0; i < n; i++)
        fill(c, part(r, 0, (i + 0.25) / n, 1, (i + 0.75) / n), k);
}

/* A block or oval in the accent colour with the brand in large letters. */
static void brand(canvas *c, rect r)
{
    const recipe *k = c->ink;
    const int n = 4 + (int)lt_rng_below(&c->rng, 4);

    if (lt_rng_below(&c->rng, 2)) {
        fill(c, r, k->panel);
        fill(c, part(r, 0.02, 0.05, 0.98, 0.95), k->accent);
    } else {
        ellipse(c, r, k->panel);
        ellipse(c, part(r, 0.03, 0.06, 0.97, 0.94), k->accent);
    }
    word(c, part(r, 0.14, 0.26, 0.86, 0.74), n, k->panel);
}

/* Overlapping round things on a plate: what is in the packet. */
static void picture(canvas *c, rect r)
{
    const recipe *k = c->ink;

    ellipse(c, r, k->panel);
    for (int i = 0; i < 7; i++) {
        const double x = lt_rng_range(&c->rng, 0.12, 0.62), y = lt_rng_range(&c->rng, 0.15, 0.55);
        const rect disc = part(r, x, y, x + 0.27, y + 0.3);
        ellipse(c, disc, k->ink);
        ellipse(c, part(disc, 0.05, 0.05, 0.93, 0.93), i % 2 ? k->accent : k->base);
        ellipse(c, part(disc, 0.25, 0.2, 0.6, 0.55), k->panel);
    }
}

static void facts(canvas *c, rect r)
{
    const color white = {{ 246, 246, 242 }}, black = {{ 24, 24, 24 }};

    fill(c, r, black);
    fill(c, part(r, 0.02, 0.01, 0.98, 0.99), white);
    word(c, part(r, 0.08, 0.03, 0.9, 0.1), 9, black);
    print_lines(c, part(r, 0.08, 0.15, 0.92, 0.97), 4, black);
}

/* ---- kinds of packaging --------------------------------------------------------------------------- */

static rect chart_rect(synth_chart i)
{
    const loft_chart *c = &synth_charts[i];

    return (rect){ c->u0 * SIZE, (1 - c->v1) * SIZE, c->u1 * SIZE, (1 - c->v0) * SIZE };
}

static void front_panel(canvas *c, rect r)
{
    brand(c, part(r, 0.1, 0.08, 0.9, 0.32));
    print_lines(c, part(r, 0.16, 0.36, 0.84, 0.46), 7, c->ink->panel);
    picture(c, part(r, 0.1, 0.48, 0.9, 0.9));
    stripes(c, part(r, 0, 0.93, 1, 0.99), 2, c->ink->accent);
}

static void back_panel(canvas *c, rect r)
{
    fill(c, part(r, 0.08, 0.3, 0.92, 0.92), c->ink->panel);
    brand(c, part(r, 0.2, 0.06, 0.8, 0.24));
    print_lines(c, part(r, 0.14, 0.34, 0.86, 0.62), 5, c->ink->ink);
    picture(c, part(r, 0.3, 0.64, 0.86, 0.9));
    stripes(c, part(r, 0, 0.94, 1, 0.98), 1, c->ink->panel);
}

/* Four sides starting with the one that faces +x; the broad pair has front and back. */
static void carton(canvas *c, const ycb_object *o)
{
    const rect side = chart_rect(CHART_SIDE);
    const double share = o->rect[1] / (2 * (o->rect[0] + o->rect[1]));      /* of the +x side */
    const double edge[5] = { 0, share, 0.5, 0.5 + share, 1 };
    const int front = share > 0.25 ? 0 : 1;

    for (int i = 0; i < 4; i++) {
        const rect r = part(side, edge[i], 0, edge[i + 1], 1);
        if (i == front) {
            front_panel(c, r);
        } else if (i == front + 2) {
            back_panel(c, r);
        } else if (i == (front + 1) % 4) {
            facts(c, part(r, 0.1, 0.12, 0.9, 0.6));
            barcode(c, part(r, 0.12, 0.7, 0.88, 0.88));
        } else {
            brand(c, part(r, 0.08, 0.1, 0.92, 0.24));
            print_lines(c, part(r, 0.12, 0.32, 0.88, 0.86), 6, c->ink->panel);
        }
    }
    brand(c, part(chart_rect(CHART_TOP), 0.25, 0.3, 0.75, 0.7));
    print_lines(c, part(chart_rect(CHART_BOTTOM), 0.3, 0.3, 0.7, 0.7), 5, c->ink->panel);
}

/* A label right round, bare metal at the rims. */
static void can(canvas *c)
{
    const rect side = chart_rect(CHART_SIDE);
    const rect r = part(side, 0, 0.06, 1, 0.94);

    fill(c, part(side, 0, 0, 1, 0.06), c->ink->top);
    fill(c, part(side, 0, 0.94, 1, 1), c->ink->top);
    fill(c, part(r, 0, 0.52, 1, 1), c->ink->panel);
    stripes(c, part(r, 0, 0.49, 1, 0.53), 1, c->ink->accent);
    brand(c, part(r, 0.05, 0.08, 0.45, 0.46));
    picture(c, part(r, 0.12, 0.56, 0.4, 0.97));
    brand(c, part(r, 0.56, 0.1, 0.84, 0.36));
    facts(c, part(r, 0.56, 0.42, 0.74, 0.96));
    barcode(c, part(r, 0.78, 0.6, 0.93, 0.9));
    ellipse(c, part(chart_rect(CHART_TOP), 0.42, 0.1, 0.58, 0.4), (color){{ 150, 152, 156 }});
    print_lines(c, part(chart_rect(CHART_BOTTOM), 0.35, 0.4, 0.65, 0.6), 5, (color){{ 60, 60, 66 }});
}

/* Front label around +y, back label around -y. */
static void bottle(canvas *c)
{
    const rect side = chart_rect(CHART_SIDE);
    const rect front = part(side, 0.06, 0.34, 0.44, 0.9), back = part(side, 0.58, 0.4, 0.92, 0.88);
    const recipe *k = c->ink;

    fill(c, front, k->panel);
    ellipse(c, part(side, 0.06, 0.26, 0.44, 0.5), k->panel);
    brand(c, part(front, 0.08, 0.02, 0.92, 0.36));
    print_lines(c, part(front, 0.2, 0.42, 0.8, 0.56), 9, k->accent);
    picture(c, part(front, 0.25, 0.58, 0.75, 0.94));
    fill(c, back, k->panel);
    stripes(c, part(back, 0, 0, 1, 0.14), 1, k->accent);
    print_lines(c, part(back, 0.06, 0.2, 0.55, 0.9), 5, k->ink);
    facts(c, part(back, 0.6, 0.18, 0.96, 0.6));
    barcode(c, part(back, 0.6, 0.68, 0.96, 0.94));
}

/* Moulded plastic or glaze: bands of nearly one colour and one small mark. */
static void plain(canvas *c)
{
    const rect side = chart_rect(CHART_SIDE);

    stripes(c, part(side, 0, 0.05, 1, 0.2), 3, c->ink->panel);
    stripes(c, part(side, 0, 0.8, 1, 0.97), 2, c->ink->accent);
    word(c, part(side, 0.18, 0.44, 0.32, 0.53), 6, c->ink->ink);
    print_lines(c, part(side, 0.68, 0.5, 0.8, 0.58), 6, c->ink->ink);
}

static color mix(color a, color b, double f)
{
    color k;

    for (int i = 0; i < 3; i++)
        k.rgb[i] = (uint8_t)lround(a.rgb[i] + f * (b.rgb[i] - a.rgb[i]));
    return k;
}

/* Grain along the height; the same on all four sides and mirrored about their middles, so that a turned
 * block looks the same. Objects with one colour keep it. */
static void wood(canvas *c)
{
    const rect r = chart_rect(CHART_SIDE);
    double phase[8];

    for (int i = 0; i < 8; i++)
        phase[i] = lt_rng_range(&c->rng, 0, 1);
    for (int x = 0; x < SIZE; x++) {
        const double u = fabs(4.0 * (x % (SIZE / 4) + 0.5) / SIZE - 0.5);   /* 0..0.5 from the middle */
        double f = 0;
        for (int i = 0; i < 8; i++)
            f += cos(2 * M_PI * (3 + 5 * i) * (u + 0.1 * phase[i])) * phase[(i + 3) % 8] / (1 + 0.3 * i);
        f = 0.5 + 0.3 * f;
        fill(c, (rect){ x, r.y0, x + 1, r.y1 }, mix(c->ink->panel, c->ink->accent, fmax(0, fmin(1, f))));
    }
}

/* Ripeness along the length, ridges, freckles, a sticker on one side. */
static void banana(canvas *c)
{
    const rect r = chart_rect(CHART_SIDE);
    const recipe *k = c->ink;

    for (int y = (int)r.y0; y < r.y1; y++) {
        const double v = (y - r.y0) / (r.y1 - r.y0), end = fmax(1 - v / 0.07, 1 - (1 - v) / 0.05);
        for (int x = 0; x < SIZE; x++) {
            const double ridge = pow(fabs(cos(2.5 * 2 * M_PI * x / SIZE)), 24);
            const color skin = mix(k->base, k->panel, fmin(1, 0.5 * ridge + 0.7 * fmax(0, 1 - v / 0.2)));
            put(c, x, y, mix(skin, k->accent, fmax(0, fmin(1, 1.6 * end))));
        }
    }
    for (int i = 0; i < 120; i++) {
        const double x = lt_rng_range(&c->rng, 0, SIZE), y = lt_rng_range(&c->rng, r.y0 + 25, r.y1 - 20);
        const double w = lt_rng_range(&c->rng, 0.6, 3), h = lt_rng_range(&c->rng, 0.6, 4);
        ellipse(c, (rect){ x - w, y - h, x + w, y + h }, k->accent);
    }
    ellipse(c, part(r, 0.2, 0.44, 0.29, 0.54), k->ink);
    word(c, part(r, 0.215, 0.47, 0.275, 0.51), 4, k->panel);
}

static void paint(canvas *c, const ycb_object *o)
{
    const recipe *k = c->ink;

    fill(c, (rect){ 0, 0, SIZE, SIZE }, k->top);
    fill(c, chart_rect(CHART_SIDE), k->base);
    fill(c, part(chart_rect(CHART_SECOND), -0.05, -0.05, 1.05, 1.05), k->second);
    fill(c, part(chart_rect(CHART_THIRD), -0.05, -0.05, 1.05, 1.05), k->third);
    switch (k->kind) {
    case CARTON: carton(c, o); break;
    case CAN: can(c); break;
    case BOTTLE: bottle(c); break;
    case PLAIN: plain(c); break;
    case WOOD: wood(c); break;
    case BANANA: banana(c); break;
    }
}

lt_status synth_object_texture(lt_arena *arena, int id, uint8_t (**rgb)[3])
{
    const ycb_object *o = synth_object_find(id);
    canvas c = { 0 };

    if (!o)
        return lt_error(LT_EINVAL, "object %d: ids are 1 to %d", id, SYNTH_OBJECTS);
    c.px = lt_arena_array(arena, (size_t)SIZE * SIZE, sizeof(*c.px));
    if (!c.px)
        return lt_error(LT_ENOMEM, "no memory for a texture");
    c.rng = lt_rng_make(PRINT, (uint64_t)id);
    c.ink = &recipes[id - 1];
    paint(&c, o);
    *rgb = c.px;
    return LT_OK;
}
