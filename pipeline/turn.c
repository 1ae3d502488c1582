/* SPDX-License-Identifier: Apache-2.0 */
/* What is around a hand, turned by quarters: a network that knows hands as they mostly stand knows others so too. */
#include "pipeline/internal.h"

#include "libtensor/geometry/mat3.h"

#include <math.h>

/* EXIF's word for pictures that are upright once they are turned clockwise by so many quarters */
static const int exif_orientation[4] = { 1, 6, 3, 8 };

/* The picture's part within a box's longer side of hand and object, which holds all that crops are made of */
static predict_turn around(const predict_view *v, int quarters)
{
    const crop_box h = v->hand_box, o = v->object_box;
    const double x0 = (double)fminf(h.x0, o.x0), y0 = (double)fminf(h.y0, o.y0);
    const double x1 = (double)fmaxf(h.x1, o.x1), y1 = (double)fmaxf(h.y1, o.y1), room = fmax(x1 - x0, y1 - y0);
    const int left = (int)fmax(0, floor(x0 - room)), top = (int)fmax(0, floor(y0 - room));

    return (predict_turn){
        .quarters = quarters, .x0 = left, .y0 = top,
        .width = (int)fmin(v->width, ceil(x1 + room)) - left, .height = (int)fmin(v->height, ceil(y1 + room)) - top,
    };
}

/* Pixels of size bytes of the part, turned; NULL without memory */
static void *turned_pixels(lt_arena *arena, const predict_turn *t, const void *picture, int width, size_t size)
{
    const size_t row = (size_t)t->width * size, rows = (size_t)t->height;
    const char *from = (const char *)picture + ((size_t)t->y0 * (size_t)width + (size_t)t->x0) * size;
    char *part = lt_arena_array(arena, 2 * rows, row);

    for (size_t y = 0; part && y < rows; y++)
        memcpy(part + y * row, from + y * (size_t)width * size, row);
    if (part)
        lt_exif_upright(exif_orientation[t->quarters], t->width, t->height, size, part, part + rows * row);
    return part ? part + rows * row : NULL;
}

/* A quarter clockwise of what was `height` high: (x, y) to (height - 1 - y, x) */
static crop_box quarter_box(crop_box b, int height)
{
    const float last = (float)(height - 1);

    return (crop_box){ last - b.y1, b.x0, last - b.y0, b.x1 };
}

static lt_camera quarter_camera(const lt_camera *c, int height)
{
    return (lt_camera){ .fx = c->fy, .fy = c->fx, .cx = height - 1 - c->cy, .cy = c->cx };
}

static crop_box shifted(crop_box b, int x0, int y0)
{
    return (crop_box){ b.x0 - (float)x0, b.y0 - (float)y0, b.x1 - (float)x0, b.y1 - (float)y0 };
}

lt_status predict_view_turn(lt_arena *arena, const predict_view *v, int quarters, predict_view *out, predict_turn *turn)
{
    const predict_turn t = around(v, quarters);

    *turn = t;
    *out = *v;
    out->rgb = turned_pixels(arena, &t, v->rgb, v->width, 3);
    out->depth = v->depth ? turned_pixels(arena, &t, v->depth, v->width, sizeof(*v->depth)) : NULL;
    if (!out->rgb || (v->depth && !out->depth))
        return lt_error(LT_ENOMEM, "%s: no memory", v->path);
    out->camera.cx -= t.x0;
    out->camera.cy -= t.y0;
    out->hand_box = shifted(v->hand_box, t.x0, t.y0);
    out->object_box = shifted(v->object_box, t.x0, t.y0);
    out->width = t.width;
    out->height = t.height;
    for (int k = 0; k < quarters; k++) {
        const int width = out->width, height = out->height;

        out->hand_box = quarter_box(out->hand_box, height);
        out->object_box = quarter_box(out->object_box, height);
        out->camera = quarter_camera(&out->camera, height);
        out->width = height;
        out->height = width;
    }
    return LT_OK;
}

/* ---- back ------------------------------------------------------------------------------------------------------ */

/* A quarter anticlockwise, to what is `height` high */
static void pixels_back(float (*p)[2], int n, int height)
{
    for (int i = 0; i < n; i++) {
        const float x = p[i][0];

        p[i][0] = p[i][1];
        p[i][1] = (float)(height - 1) - x;
    }
}

/* The same about the optical axis */
static void points_back(float (*p)[3], int n)
{
    for (int i = 0; i < n; i++) {
        const float x = p[i][0];

        p[i][0] = p[i][1];
        p[i][1] = -x;
    }
}

static const lt_pose BACK = { .R = { 0, 1, 0, -1, 0, 0, 0, 0, 1 } };

static void rotation_back(float R[9])
{
    double from[9], to[9];

    for (int k = 0; k < 9; k++)
        from[k] = R[k];
    lt_mat3_mul(BACK.R, from, to);
    for (int k = 0; k < 9; k++)
        R[k] = (float)to[k];
}

static void quarter_back(predict_result *r, int height)
{
    pixels_back(r->heatmap2d, LT_HAND_KEYPOINTS, height);
    pixels_back(r->control2d, LT_BOX_POINTS, height);
    points_back(r->e.joints, LT_HAND_KEYPOINTS);
    points_back(r->e.vertices, LT_HAND_VERTICES);
    rotation_back(r->e.rotation[0]);
    r->e.object = lt_pose_compose(&BACK, &r->e.object);
}

static void shift_back(float (*p)[2], int n, const predict_turn *t)
{
    for (int i = 0; i < n; i++) {
        p[i][0] += (float)t->x0;
        p[i][1] += (float)t->y0;
    }
}

void predict_turn_back(const predict_turn *t, predict_result *r)
{
    for (int k = t->quarters; k > 0; k--)
        quarter_back(r, k % 2 ? t->height : t->width);
    if (t->quarters == 0)
        return;
    shift_back(r->heatmap2d, LT_HAND_KEYPOINTS, t);
    shift_back(r->control2d, LT_BOX_POINTS, t);
}
