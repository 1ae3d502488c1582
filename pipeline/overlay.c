/* SPDX-License-Identifier: Apache-2.0 */
/* The photograph with everything that was found, and how far to believe it. */
#include "pipeline/internal.h"

#include "vision/drawing/body.h"
#include "vision/drawing/pose.h"

#include <math.h>
#include <string.h>

static const draw_color PAPER = { 20, 20, 20 }, INK = { 245, 245, 245 }, WARN = { 255, 120, 100 };
static const draw_color HAND_BOX = { 255, 255, 255 }, OBJECT_BOX = { 255, 220, 120 }, PERSON_BOX = { 120, 175, 255 };

static void draw_input_box(draw_canvas *c, crop_box b, float width, draw_color color)
{
    const float p[4][2] = { { b.x0, b.y0 }, { b.x1, b.y0 }, { b.x1, b.y1 }, { b.x0, b.y1 } };

    for (int i = 0; i < 4; i++)
        draw_line(c, p[i], p[(i + 1) % 4], width, color, 0.7f);
}

/* One line on a dark strip; returns where the next begins. */
static int draw_note(draw_canvas *c, int y, int scale, draw_color color, const char *text)
{
    const int height = scale * (DRAW_GLYPH_HEIGHT + 3);

    draw_rect(c, 0, y, c->width, y + height, PAPER, 0.65f);
    draw_text(c, 3 * scale, y + 2 * scale, scale, color, text);
    return y + height;
}

static int note_hand(draw_canvas *c, int y, int scale, const predict_view *v, const predict_result *r)
{
    const bool trusted = predict_trusted(v, r);
    char line[160];

    snprintf(line, sizeof(line), "%s hand  z %.2f m%s  2D-3D agreement %.1f px%s", v->left ? "left" : "right",
             (double)r->e.joints[0][2], r->placed ? "" : " (a guess)", r->agreement_px, trusted ? "" : "  LOW TRUST");
    return draw_note(c, y, scale, trusted ? INK : WARN, line);
}

static int note_body(draw_canvas *c, int y, int scale, const predict_person *p)
{
    char line[160];

    snprintf(line, sizeof(line), "body  z %.1f m, roughly", p->body.pelvis[2]);
    return draw_note(c, y, scale, INK, line);
}

static int count_seen(const predict_result *r)
{
    int n = 0;

    for (int i = 0; i < LT_BOX_POINTS; i++)
        n += isfinite(r->control2d[i][0]) && isfinite(r->control2d[i][1]);
    return n;
}

static int note_object(draw_canvas *c, int y, int scale, const predict_view *v, const predict_result *r)
{
    char line[160];

    if (!v->object)
        snprintf(line, sizeof(line), "object not named  %d of %d points of its box seen  confidence %.2f",
                 count_seen(r), LT_BOX_POINTS, (double)r->e.object_confidence);
    else if (r->object_found)
        snprintf(line, sizeof(line), "%s  z %.2f m  %d inliers  confidence %.2f%s", v->object->name,
                 r->e.object.t[2], r->e.object_inliers, (double)r->e.object_confidence,
                 predict_object_trusted(v, r) ? "" : "  LOW TRUST");
    else
        snprintf(line, sizeof(line), "%s  NO POSE FOUND  confidence %.2f", v->object->name,
                 (double)r->e.object_confidence);
    return draw_note(c, y, scale, !v->object || predict_object_trusted(v, r) ? INK : WARN, line);
}

/* Where the boxes are from */
static void say_boxes(const predict_frame *f, char *line, size_t room)
{
    int n[] = { [DETECTED_HAND] = 0, [DETECTED_OBJECT] = 0, [DETECTED_PERSON] = 0 };

    for (int i = 0; i < f->n_detections; i++)
        n[f->detection[i].kind]++;
    if (f->detected)
        snprintf(line, room, "detected: %d hand%s, %d object%s, %d person%s", n[DETECTED_HAND],
                 n[DETECTED_HAND] == 1 ? "" : "s", n[DETECTED_OBJECT], n[DETECTED_OBJECT] == 1 ? "" : "s",
                 n[DETECTED_PERSON], n[DETECTED_PERSON] == 1 ? "" : "s");
    else if (f->n)
        snprintf(line, room, "boxes: hand %s, object %s", predict_source_name(f->view->hand_from),
                 predict_source_name(f->view->object_from));
    else
        snprintf(line, room, "box of the person: %s", predict_source_name(f->person->from));
}

/* Of many hands and bodies those that leave three quarters of the picture free */
static void draw_notes(draw_canvas *c, const predict_frame *f)
{
    const int scale = (int)lt_max_i64(1, lt_min_i64(c->width / 500, c->height / 300));
    const predict_view *v = f->view;
    char line[160];
    size_t n;
    int y = 0;

    for (int i = 0; i < f->n && y < c->height / 4 && (f->has & FRAME_POSES); i++) {
        y = note_hand(c, y, scale, &v[i], &f->result[i]);
        y = note_object(c, y, scale, &v[i], &f->result[i]);
    }
    for (int i = 0; i < f->n_people && y < c->height / 4; i++)
        y = note_body(c, y, scale, &f->person[i]);
    say_boxes(f, line, sizeof(line));
    n = strlen(line);
    if (f->o->m || f->o->body)
        snprintf(line + n, sizeof(line) - n, "  camera: %s", predict_source_name(f->scene.camera_from));
    draw_note(c, y, scale, INK, line);
}

/* Of a hand that cannot be trusted the joints as the heat maps have them, which are in its box at least. Without an
 * object by name the points of its box are drawn where the boxes were given, not where a detector saw none. */
static lt_status draw_hand(lt_arena *arena, draw_canvas *c, const predict_view *v, const predict_result *r,
                           const lt_mesh *hand, float width)
{
    const pose_drawing all = {
        .joints = r->e.joints, .vertices = r->e.vertices, .faces = hand->face,
        .object = r->object_found && predict_object_trusted(v, r) ? &r->e.object : NULL,
        .control = v->object ? v->object->control : NULL, .mesh = v->object ? &v->object->mesh : NULL,
        .control2d = v->object || !v->hand_seen ? r->control2d : NULL,
    };

    if (!v->hand_seen) {
        draw_input_box(c, v->object_box, width, OBJECT_BOX);
        draw_input_box(c, v->hand_box, width, HAND_BOX);
    }
    if (predict_trusted(v, r))
        return pose_draw(arena, c, &v->camera, &all, width);
    draw_skeleton(c, (const float (*)[2])r->heatmap2d, 4 * width);
    return LT_OK;
}

static void draw_body(draw_canvas *c, const predict_person *p, float width)
{
    if (!p->seen)
        draw_input_box(c, p->box, width, PERSON_BOX);
    body_draw(c, p->body.nodes2d, width);
}

lt_status predict_draw_overlay(const predict_frame *f, lt_image *out)
{
    const predict_view *v = &f->scene;
    const float width = fmaxf(1, (float)lt_min_i64(v->width, v->height) / 480);
    draw_canvas c = draw_canvas_new(f->arena, v->width, v->height, PAPER);
    lt_status st = LT_OK;

    if (!c.rgb)
        return lt_error(LT_ENOMEM, "%s: no memory to draw on %d x %d pixels", v->path, v->width, v->height);
    memcpy(c.rgb, v->rgb, 3 * (size_t)v->width * (size_t)v->height);
    predict_draw_detections(&c, f, width);
    for (int i = 0; i < f->n_people; i++)
        draw_body(&c, &f->person[i], width);
    for (int i = 0; i < f->n && !st && (f->has & FRAME_POSES); i++)
        st = draw_hand(f->arena, &c, &f->view[i], &f->result[i], &f->hand[i], width);
    if (st)
        return st;
    draw_notes(&c, f);
    *out = (lt_image){ v->width, v->height, 3, 8, c.rgb[0] };
    return LT_OK;
}
