/* SPDX-License-Identifier: Apache-2.0 */
/* A photograph made ready: upright, with boxes and a camera, given or assumed. */
#include "pipeline/internal.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"

#include <string.h>

#define FILE_MAX ((size_t)1 << 30)

static const double CENTRAL = 0.6, OBJECT_GROWTH = 1.3;

const char *predict_source_name(predict_source s)
{
    static const char *const name[] = { "given", "listed", "detected", "exif", "default" };

    return name[s];
}

static lt_status read_upright(lt_arena *arena, const char *path, lt_exif *exif, predict_view *v)
{
    lt_image img, stored;
    uint8_t *bytes, *rgb;
    size_t n;
    lt_status st = lt_read_file(arena, path, FILE_MAX, &bytes, &n);

    st = st ? st : lt_image_decode(arena, path, bytes, n, &img);
    st = st ? st : lt_image_to_rgb8(arena, &img, &stored);
    if (st)
        return st;
    *exif = lt_exif_read(bytes, n);
    v->orientation = exif->orientation;
    v->width = exif->orientation < 5 ? stored.width : stored.height;
    v->height = exif->orientation < 5 ? stored.height : stored.width;
    v->rgb = stored.data;
    if (exif->orientation == 1)
        return LT_OK;
    st = lt_arena_try(arena, lt_image_bytes(&stored), (void **)&rgb);
    if (st)
        return lt_error_prefix(st, "%s", path);
    lt_exif_upright(exif->orientation, stored.width, stored.height, 3, stored.data, rgb);
    v->rgb = rgb;
    return LT_OK;
}

crop_box predict_default_hand_box(int width, int height)
{
    const double half = CENTRAL * (width < height ? width : height) / 2;
    const double cx = (width - 1) / 2.0, cy = (height - 1) / 2.0;

    return (crop_box){ (float)(cx - half), (float)(cy - half), (float)(cx + half), (float)(cy + half) };
}

crop_box predict_default_object_box(crop_box b)
{
    const double cx = (b.x0 + b.x1) / 2, cy = (b.y0 + b.y1) / 2;
    const double hx = (b.x1 - b.x0) * OBJECT_GROWTH / 2, hy = (b.y1 - b.y0) * OBJECT_GROWTH / 2;

    return (crop_box){ (float)(cx - hx), (float)(cy - hy), (float)(cx + hx), (float)(cy + hy) };
}

void predict_choose_side(const predict_options *o, predict_side said, predict_view *v)
{
    v->any_side = said == PREDICT_ANY_SIDE && o->any_side;
    v->left = said == PREDICT_ANY_SIDE ? o->left : said == PREDICT_LEFT;
}

/* row: the hand's line in --boxes, or NULL. Boxes are of the picture as the lens made it. */
static void choose_hand(const predict_options *o, const predict_boxes_row *row, const predict_object *given,
                        predict_view *v)
{
    const bool hand = row && row->has_hand, object = row && row->has_object;

    v->hand_box = hand ? row->hand : o->hand_box ? *o->hand_box
                         : predict_default_hand_box(v->width, v->height);
    v->hand_from = hand ? PREDICT_LISTED : o->hand_box ? PREDICT_GIVEN : PREDICT_DEFAULT;
    v->object_box = object ? row->object : o->object_box ? *o->object_box
                             : predict_default_object_box(v->hand_box);
    v->object_from = object ? PREDICT_LISTED : o->object_box ? PREDICT_GIVEN : PREDICT_DEFAULT;
    predict_choose_side(o, row ? row->side : PREDICT_ANY_SIDE, v);
    v->object = predict_hand_alone(o) ? NULL : row && row->model ? row->model : given;
}

lt_status predict_check_inside(const predict_view *v, const char *what, crop_box b)
{
    if (!(b.x1 > b.x0 && b.y1 > b.y0))
        return lt_error(LT_EINVAL, "%s: the %s box is empty", v->path, what);
    if (b.x1 < 1 || b.y1 < 1 || b.x0 > (float)v->width - 1 || b.y0 > (float)v->height - 1)
        return lt_error(LT_EINVAL, "%s: the %s box %g,%g,%g,%g lies outside the image of %d x %d pixels",
                        v->path, what, (double)b.x0, (double)b.y0, (double)b.x1, (double)b.y1, v->width,
                        v->height);
    return LT_OK;
}

lt_status predict_scene_open(predict_frame *f)
{
    const lt_image *picture = f->picture;
    const predict_input *in = &f->input;
    predict_view *v = &f->scene;
    lt_exif exif = { .orientation = 1 };
    lt_status st = LT_OK;

    *v = (predict_view){ .path = in->path, .name = in->name, .orientation = in->orientation };
    if (picture)
        v->width = picture->width, v->height = picture->height, v->rgb = picture->data;
    else
        st = read_upright(f->arena, in->path, &exif, v);
    if (!st && in->depth)
        st = predict_read_depth(f->arena, f->o, in->depth, v, &f->notes);
    if (st)
        return st;
    predict_choose_camera(f->o, &exif, v, &f->notes);
    return predict_undistort(f->arena, f->o, v, &f->notes);
}

/* Hand i of the image; row: its line in --boxes, or NULL */
static lt_status open_hand(const predict_options *o, const predict_boxes_row *row, const predict_object *given,
                           predict_view *v)
{
    lt_status st;

    choose_hand(o, row, given, v);
    st = predict_check_inside(v, "hand", v->hand_box);
    st = st ? st : predict_check_inside(v, "object", v->object_box);
    if (st)
        return row ? lt_error_prefix(st, "%s:%lld", o->boxes, (long long)row->line) : st;
    if (v->hand_from != PREDICT_DEFAULT)
        v->hand_box = predict_undistort_box(v, v->hand_box);
    if (v->object_from != PREDICT_DEFAULT || v->hand_from != PREDICT_DEFAULT)
        v->object_box = predict_undistort_box(v, v->object_box);
    return LT_OK;
}

lt_status predict_views_new(predict_frame *f, int n)
{
    f->n = n;
    f->view = lt_arena_array(f->arena, (size_t)n, sizeof(*f->view));
    if (!f->view)
        return lt_error(LT_ENOMEM, "%s: no memory", f->scene.path);
    for (int i = 0; i < n; i++) {
        f->view[i] = f->scene;
        f->view[i].hand = i;
        f->view[i].n_hands = n;
    }
    return LT_OK;
}

lt_status predict_views_listed(predict_frame *f)
{
    const predict_input *in = &f->input;
    lt_status st = predict_views_new(f, in->n_boxes ? (int)in->n_boxes : 1);

    for (int i = 0; i < f->n && !st; i++)
        st = open_hand(f->o, in->n_boxes ? &in->boxes[i] : NULL, f->object, &f->view[i]);
    return st;
}

static crop_box mirrored_box(crop_box b, int width)
{
    const float last = (float)(width - 1);

    return (crop_box){ last - b.x1, b.y0, last - b.x0, b.y1 };
}

lt_status predict_view_mirror(lt_arena *arena, const predict_view *v, predict_view *out)
{
    const size_t width = (size_t)v->width, rows = (size_t)v->height;
    float *depth = NULL;
    uint8_t *rgb;
    lt_status st = lt_arena_try(arena, 3 * width * rows, (void **)&rgb);

    if (!st && v->depth)
        st = lt_arena_try(arena, width * rows * sizeof(*depth), (void **)&depth);
    if (st)
        return lt_error_prefix(st, "%s", v->path);
    for (size_t y = 0; y < rows; y++)
        for (size_t x = 0; x < width; x++) {
            const size_t to = y * width + x, from = y * width + width - 1 - x;

            memcpy(rgb + 3 * to, v->rgb + 3 * from, 3);
            if (depth)
                depth[to] = v->depth[from];
        }
    *out = *v;
    out->rgb = rgb;
    out->depth = depth;
    out->hand_box = mirrored_box(v->hand_box, v->width);
    out->object_box = mirrored_box(v->object_box, v->width);
    out->camera.cx = v->width - 1 - v->camera.cx;
    return LT_OK;
}
