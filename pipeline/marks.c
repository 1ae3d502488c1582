/* SPDX-License-Identifier: Apache-2.0 */
/* What a detector saw, drawn: masks, boxes, classes and scores. */
#include "pipeline/internal.h"

static const draw_color PAPER = { 20, 20, 20 };

/* Hands and people have a colour each, objects one of six by class. */
static draw_color color_of(const predict_detection *d)
{
    static const draw_color hand = { 255, 150, 80 }, person = { 120, 175, 255 };
    static const draw_color object[] = {
        { 255, 220, 120 }, { 120, 220, 140 }, { 230, 130, 220 }, { 110, 215, 220 }, { 240, 120, 120 }, { 190, 200, 90 },
    };

    return d->kind == DETECTED_HAND ? hand : d->kind == DETECTED_PERSON ? person : object[d->cls % LT_COUNT(object)];
}

/* Runs of the mask along each row */
static void tint(draw_canvas *c, const detection_pixels *w, draw_color color)
{
    for (int y = w->y0; w->pixel && y < w->y1; y++) {
        const uint8_t *row = w->pixel + (size_t)(y - w->y0) * (size_t)(w->x1 - w->x0) - w->x0;

        for (int x = w->x0, from = x; x <= w->x1; x++)
            if (x == w->x1 || !row[x]) {
                if (from < x)
                    draw_rect(c, from, y, x, y + 1, color, 0.35f);
                from = x + 1;
            }
    }
}

static void outline(draw_canvas *c, crop_box b, float width, draw_color color)
{
    const float p[4][2] = { { b.x0, b.y0 }, { b.x1, b.y0 }, { b.x1, b.y1 }, { b.x0, b.y1 } };

    for (int i = 0; i < 4; i++)
        draw_line(c, p[i], p[(i + 1) % 4], width, color, 0.9f);
}

/* Above the box, or in it where there is no room; not beyond the picture's right edge */
static void label(draw_canvas *c, const predict_detection *d)
{
    const int scale = (int)lt_max_i64(1, lt_min_i64(c->width / 500, c->height / 300));
    const int height = scale * (DRAW_GLYPH_HEIGHT + 2);
    char text[96];
    const int n = d->track ? snprintf(text, sizeof(text), "#%lld %.60s %.2f", (long long)d->track, d->name, d->score)
                           : snprintf(text, sizeof(text), "%.60s %.2f", d->name, d->score);
    const int wide = scale * (DRAW_GLYPH_WIDTH * n + 3);
    const int left = (int)lt_max_i64(0, lt_min_i64((int)d->box.x0, c->width - wide));
    const int above = (int)d->box.y0 - height, top = above < 0 ? above + height : above;

    draw_rect(c, left, top, left + wide, top + height, PAPER, 0.6f);
    draw_text(c, left + 2 * scale, top + scale, scale, color_of(d), text);
}

/* The least sure first, so that the surest stay to be seen */
void predict_draw_detections(draw_canvas *c, const predict_frame *f, float width)
{
    for (int i = f->n_detections; i-- > 0; )
        tint(c, &f->detection[i].window, color_of(&f->detection[i]));
    for (int i = f->n_detections; i-- > 0; )
        outline(c, f->detection[i].box, width, color_of(&f->detection[i]));
    for (int i = f->n_detections; i-- > 0; )
        label(c, &f->detection[i]);
}
