/* SPDX-License-Identifier: Apache-2.0 */
/* Print: labels of boxes and pages of books. Every draw stands in a statement of its own, as in pattern.c. */
#include "synth/render/small.h"
#include "synth/room/paint.h"
#include "synth/room/pattern.h"

enum { LABEL = 256 };

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
                c->px[y][x][k] = paint_byte(rgb[k]);
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
