/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures with what was found, and what was not. */
#include "tasks/detect/breakdown.h"
#include "tasks/detect/kept.h"

#include "libtensor/io/image/write.h"
#include "vision/drawing/draw.h"

#include <math.h>
#include <stdio.h>

enum { SIDE = 400, COLUMNS = 3, MOST = 12 };

static const draw_color PAPER = { 40, 40, 40 }, SEEN = { 255, 255, 255 }, MISSED = { 255, 90, 90 };
static const draw_color RIGHT = { 110, 230, 130 }, WRONG = { 255, 170, 60 };

typedef struct {
    draw_canvas c;
    float scale, left, top;         /* of the picture in it */
} tile;

static void box(tile *t, const float b[4], float width, draw_color color, const char *name, double score)
{
    const float x0 = t->left + t->scale * b[0], y0 = t->top + t->scale * b[1];
    const float x1 = t->left + t->scale * b[2], y1 = t->top + t->scale * b[3];
    const float p[4][2] = { { x0, y0 }, { x1, y0 }, { x1, y1 }, { x0, y1 } };
    char text[64];

    for (int i = 0; i < 4; i++)
        draw_line(&t->c, p[i], p[(i + 1) % 4], width, color, 0.9f);
    if (!name)
        return;
    if (score > 0)
        snprintf(text, sizeof(text), "%.24s %.2f", name, score);
    else
        snprintf(text, sizeof(text), "%.24s", name);
    draw_text(&t->c, (int)x0 + 2, score > 0 ? (int)y0 + 2 : (int)y1 - DRAW_GLYPH_HEIGHT, 1, color, text);
}

/* The truth thin, red where it was missed; above it what was found, by whether it is right. */
static void draw_boxes(const detection_set *set, const kept *k, const detect_match *m, tile *t)
{
    for (int i = 0; i < k->head.n_truth; i++) {
        const kept_truth *o = &k->truth[i];
        const bool missed = m->finder_of[i] == DETECT_NOBODY && !o->crowd;

        box(t, o->box, missed ? 2 : 1, missed ? MISSED : SEEN, missed ? set->class_name[o->cls] : NULL, 0);
    }
    for (int f = k->head.n_found; f-- > 0; ) {
        const int object = m->object_of[f];
        const bool right = object >= 0 && k->truth[object].cls == k->found[f].cls;

        if (object >= 0 || object == DETECT_NOBODY)
            box(t, k->found[f].box, 2, right ? RIGHT : WRONG, set->class_name[k->found[f].cls],
                (double)k->found[f].score);
    }
}

/* *out.c.rgb NULL: the picture cannot be read any more */
static lt_status draw(lt_arena *arena, const detection_set *set, const records *all, int64_t place, tile *out)
{
    detection_sample s;
    detect_match m;
    draw_canvas picture;
    kept k;
    lt_status st = kept_read(arena, all, place, &k);

    out->c = (draw_canvas){ NULL, 0, 0 };
    st = st ? st : detect_match_of(arena, all, place, &m);
    if (st || detection_read(set, all->place[place].sample, arena, &s))
        return st;
    picture = (draw_canvas){ (uint8_t (*)[3])s.rgb.data, s.rgb.width, s.rgb.height };
    out->c = draw_canvas_new(arena, SIDE, SIDE, PAPER);
    if (!out->c.rgb)
        return lt_error(LT_ENOMEM, "no memory for the pictures");
    out->scale = (float)SIDE / (float)lt_max_i64(picture.width, picture.height);
    out->left = (SIDE - out->scale * (float)picture.width) / 2;
    out->top = (SIDE - out->scale * (float)picture.height) / 2;
    draw_picture(&out->c, (int)out->left, (int)out->top, (int)lt_max_i64(1, lrintf(out->scale * (float)picture.width)),
                 (int)lt_max_i64(1, lrintf(out->scale * (float)picture.height)), &picture);
    draw_boxes(set, &k, &m, out);
    return LT_OK;
}

lt_status detect_worst_write(const detection_set *set, const records *all, const int64_t *place, int n,
                             const char *path)
{
    lt_arena *arena = lt_arena_new();
    draw_canvas picture[MOST], sheet;
    const char *title[MOST];
    int drawn = 0;
    lt_status st = arena ? LT_OK : lt_error(LT_ENOMEM, "no memory for the pictures");

    for (int i = 0; i < n && i < MOST && !st; i++) {
        tile t;

        st = draw(arena, set, all, place[i], &t);
        title[drawn] = set->image[all->place[place[i]].sample].name;
        picture[drawn] = t.c;
        drawn += !st && t.c.rgb;
    }
    if (!st && drawn) {
        sheet = draw_sheet(arena, picture, title, drawn, COLUMNS, SIDE, SIDE);
        st = sheet.rgb ? lt_png_write(path, &(lt_image){ sheet.width, sheet.height, 3, 8, sheet.rgb[0] })
                       : lt_error(LT_ENOMEM, "no memory for the pictures");
    }
    lt_arena_free(arena);
    return st;
}
