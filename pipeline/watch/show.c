/* SPDX-License-Identifier: Apache-2.0 */
/* What is known of a set, drawn over its pictures. */
#include "pipeline/watch/internal.h"

#include "vision/drawing/body.h"

#include <math.h>
#include <string.h>

static const draw_color PAPER = { 20, 20, 20 }, INK = { 240, 240, 240 };

static bool in_picture(const recording_camera *c, const double p[3], float uv[2])
{
    double at[3], pixel[2];
    bool before;

    watch_to_camera(c, p, at);
    before = lt_camera_project(&c->K, at, pixel);
    uv[0] = (float)pixel[0];
    uv[1] = (float)pixel[1];
    return before;
}

static void draw_person(draw_canvas *canvas, const recording_camera *c, const watch_person *p)
{
    float node[ACTION_BODY][2];

    for (int i = 0; i < ACTION_BODY; i++)
        if (!in_picture(c, p->joint[i], node[i]))
            node[i][0] = node[i][1] = NAN;
    body_draw(canvas, (const float (*)[2])node, 1);
}

static void draw_hand(draw_canvas *canvas, const recording_camera *c, const watch_thing *hand)
{
    float uv[LT_HAND_KEYPOINTS][2];
    bool before = true;

    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        before = in_picture(c, hand->joint[i].x, uv[i]) && before;
    if (before)
        draw_skeleton(canvas, (const float (*)[2])uv, 3);
}

/* What each person does, in the upper left corner */
static void draw_words(const watch_world *w, const watch_set *set, draw_canvas *canvas, const recording_camera *c)
{
    char text[160];
    int y = 4;

    snprintf(text, sizeof(text), "%.40s  %.2f s", c->name, set->t);
    draw_rect(canvas, 0, 0, 8 + (int)strlen(text) * DRAW_GLYPH_WIDTH, 4 + DRAW_GLYPH_HEIGHT + 3, PAPER, 0.6f);
    draw_text(canvas, 4, y, 1, INK, text);
    for (int i = 0; i < w->n_people; i++) {
        const watch_person *p = &w->person[i];
        const watch_action a = p->action;

        snprintf(text, sizeof(text), "#%lld %s  %.40s %.2f", (long long)p->id, interaction_names[p->interaction.state],
                 a.cls < 0 ? "" : action_classes[a.cls], a.cls < 0 ? 0 : a.p);
        y += DRAW_GLYPH_HEIGHT + 4;
        draw_rect(canvas, 0, y - 1, 8 + (int)strlen(text) * DRAW_GLYPH_WIDTH, y + DRAW_GLYPH_HEIGHT + 2, PAPER, 0.6f);
        draw_text(canvas, 4, y, 1, INK, text);
    }
}

static lt_status draw_camera(const watch_world *w, const watch_set *set, int c, draw_canvas *out)
{
    const recording_camera *camera = &w->o->rig.camera[c];
    const watch_eye *e = &w->eye[c];
    const size_t bytes = 3 * (size_t)camera->width * (size_t)camera->height;
    predict_detection *seen = lt_arena_array(w->arena, (size_t)e->n, sizeof(*seen));
    predict_frame f = { .detection = seen, .n_detections = e->n };
    uint8_t *rgb = lt_arena_alloc(w->arena, bytes);

    if (!seen || !rgb)
        return lt_error(LT_ENOMEM, "no memory for a picture");
    memcpy(rgb, set->picture[c].rgb.data, bytes);
    *out = (draw_canvas){ (uint8_t (*)[3])rgb, camera->width, camera->height };
    for (int i = 0; i < e->n; i++) {
        seen[i] = e->sight[i].seen;
        seen[i].track = e->sight[i].id;
    }
    predict_draw_detections(out, &f, 1.5f);
    for (int i = 0; i < w->n_people; i++)
        if (w->person[i].state != LT_FILTER_OFF && (camera->placed || w->person[i].camera == c))
            draw_person(out, camera, &w->person[i]);
    for (int i = 0; i < w->n_things; i++)
        if (w->thing[i].state != LT_FILTER_OFF && (camera->placed || w->thing[i].camera == c))
            draw_hand(out, camera, &w->thing[i]);
    draw_words(w, set, out, camera);
    return LT_OK;
}

/* One beside the other, two rows of more than two; each as large as the first */
lt_status watch_draw(const watch_world *w, const watch_set *set, lt_image *out)
{
    const recording_rig *rig = &w->o->rig;
    const int columns = rig->n < 2 ? 1 : 2, rows = (rig->n + columns - 1) / columns;
    const int width = rig->camera[0].width, height = rig->camera[0].height;
    draw_canvas sheet = draw_canvas_new(w->arena, columns * width, rows * height, PAPER), picture;

    if (!sheet.rgb)
        return lt_error(LT_ENOMEM, "no memory for a picture");
    for (int c = 0; c < rig->n; c++) {
        const lt_status st = set->there[c] ? draw_camera(w, set, c, &picture) : LT_OK;

        if (st)
            return st;
        if (set->there[c])
            draw_picture(&sheet, c % columns * width, c / columns * height, width, height, &picture);
    }
    *out = (lt_image){ sheet.width, sheet.height, 3, 8, (uint8_t *)sheet.rgb };
    return LT_OK;
}
