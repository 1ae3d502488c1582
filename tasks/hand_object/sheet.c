/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/hand_object/sheet.h"

#include "data/mirror.h"
#include "libtensor/io/image/image.h"
#include "vision/crop.h"
#include "vision/drawing/pose.h"

#include <math.h>
#include <string.h>

enum { TILE = 288, COLUMNS = 4, MOST = 100 };       /* two columns a sample */

static const double ROOM = 1.5;                     /* as hand_object's crop */

static crop_window window_of(const dataset_sample *s)
{
    const float corner[2][2] = { { s->hand_box[0], s->hand_box[1] }, { s->hand_box[2], s->hand_box[3] } };
    const bool joints = s->flags & SAMPLE_JOINTS;
    const crop_box hand = joints ? crop_box_around(s->joints2d, LT_HAND_KEYPOINTS, ROOM)
                                 : crop_box_around(corner, 2, ROOM);
    const crop_box object = s->flags & SAMPLE_OBJECT ? crop_box_around(s->control2d, 21, ROOM) : hand;

    return crop_window_around(hand, object, s->width, s->height);
}

/* The window of the image as a canvas; rgb NULL without memory. */
static draw_canvas cut_out(lt_arena *arena, const dataset_sample *s, const double A[6])
{
    const size_t plane = (size_t)TILE * TILE;
    float *planes = lt_arena_array(arena, 3 * plane, sizeof(*planes));
    draw_canvas c = draw_canvas_new(arena, TILE, TILE, (draw_color){ 0, 0, 0 });

    if (!planes || !c.rgb)
        return (draw_canvas){ NULL, 0, 0 };
    crop_warp(A, s->rgb, s->width, s->height, NULL, planes, TILE, true);
    for (size_t i = 0; i < plane; i++)
        for (size_t k = 0; k < 3; k++)
            c.rgb[i][k] = (uint8_t)(255 * planes[k * plane + i] + 0.5f);
    return c;
}

static pose_drawing truth_of(const sheet_item *m, const int32_t (*faces)[3], lt_pose *pose)
{
    const dataset_sample *s = m->sample;
    pose_drawing p = { .faces = faces };

    if (s->flags & SAMPLE_JOINTS)
        p.joints = s->joints;
    if (faces)
        p.vertices = m->vertices ? m->vertices : s->flags & SAMPLE_VERTICES ? s->vertices : NULL;
    if (m->object && s->flags & SAMPLE_OBJECT) {
        *pose = lt_pose_of(s->R, s->t);
        mirror_model(pose->R, s->flags & SAMPLE_MIRRORED);
        p.object = pose;
        p.control = m->object->control;
        p.mesh = &m->object->mesh;
    }
    return p;
}

static pose_drawing prediction_of(const sheet_item *m, const int32_t (*faces)[3], lt_pose *pose)
{
    const estimate *e = m->estimate;
    pose_drawing p = { .faces = faces, .joints = e->joints, .vertices = faces ? e->vertices : NULL };

    if (m->object && e->object_inliers > 0) {
        *pose = e->object;
        mirror_model(pose->R, m->sample->flags & SAMPLE_MIRRORED);
        p.object = pose;
        p.control = m->object->control;
        p.mesh = &m->object->mesh;
    }
    return p;
}

static lt_status draw_item(lt_arena *arena, const sheet_item *m, const int32_t (*faces)[3],
                           draw_canvas picture[2], const char *title[2])
{
    lt_pose pose[2];
    const pose_drawing truth = truth_of(m, faces, &pose[0]), predicted = prediction_of(m, faces, &pose[1]);
    lt_camera camera;
    double A[6];
    lt_status st;

    crop_affine(window_of(m->sample), TILE, A);
    camera = lt_camera_crop(&m->sample->camera, A);
    for (int i = 0; i < 2; i++) {
        picture[i] = cut_out(arena, m->sample, A);
        if (!picture[i].rgb)
            return lt_error(LT_ENOMEM, "no memory for a contact sheet");
        st = pose_draw(arena, &picture[i], &camera, i ? &predicted : &truth, 1);
        if (st)
            return st;
    }
    title[0] = m->title ? m->title : m->sample->name;
    title[1] = "predicted";
    return LT_OK;
}

static lt_status draw_all(lt_arena *arena, const sheet_item *item, int n, const int32_t (*faces)[3],
                          draw_canvas *sheet)
{
    draw_canvas *picture = lt_arena_array(arena, 2 * (size_t)n, sizeof(*picture));
    const char **title = lt_arena_array(arena, 2 * (size_t)n, sizeof(*title));
    lt_status st = picture && title ? LT_OK : lt_error(LT_ENOMEM, "no memory for a contact sheet");

    for (int i = 0; i < n && !st; i++)
        st = draw_item(arena, &item[i], faces, picture + 2 * i, title + 2 * i);
    if (st)
        return st;
    *sheet = draw_sheet(arena, picture, title, 2 * n, COLUMNS, TILE, TILE);
    return sheet->rgb ? LT_OK : lt_error(LT_ENOMEM, "no memory for a contact sheet of %d samples", n);
}

lt_status predict_sheet(const char *path, const sheet_item *item, int n, const int32_t (*faces)[3])
{
    draw_canvas sheet;
    lt_arena *arena;
    lt_status st;

    if (n < 1 || n > MOST)
        return lt_error(LT_EINVAL, "%s: a contact sheet of %d samples, want 1 to %d", path, n, MOST);
    arena = lt_arena_new();
    st = arena ? draw_all(arena, item, n, faces, &sheet) : lt_error(LT_ENOMEM, "%s: no memory", path);
    if (!st)
        st = lt_png_write(path, &(lt_image){ sheet.width, sheet.height, 3, 8, sheet.rgb[0] });
    lt_arena_free(arena);
    return st;
}
