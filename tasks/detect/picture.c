/* SPDX-License-Identifier: Apache-2.0 */
#include "tasks/detect/picture.h"

#include "vision/augment.h"
#include "vision/detection/letterbox.h"

#include <math.h>
#include <string.h>

enum { PROTO_STRIDE = 4, TILES = 4 };

/* Boxes that are smaller than this in pixels, or have less of themselves left than this share, are no objects. */
static const double LEAST_SIDE = 2, LEAST_SHARE = 0.1;

int picture_words(int size)
{
    return (int)lt_ceil_div((size / PROTO_STRIDE) * (size / PROTO_STRIDE), 32);
}

/* ---- one of the dataset's pictures, and where it goes ---- */

typedef struct { double x0, y0, x1, y1; } area;

/* From the pixels of the dataset's picture to those of ours: x sx + tx, y sy + ty. sx is below 0 in a mirror. */
typedef struct {
    double sx, sy, tx, ty;
    area part;                      /* of ours, that it may cover */
} tile;

static double source_x(const tile *t, double x)
{
    return (x - t->tx) / t->sx;
}

static double source_y(const tile *t, double y)
{
    return (y - t->ty) / t->sy;
}

/* The first pixel whose centre is at x or behind it */
static int pixel(double x, int size)
{
    return x <= 0.5 ? 0 : x >= size ? size : (int)ceil(x - 0.5);
}

/* The two pixels around a place along a side of n, and the second one's share */
typedef struct { int a, b; float share; } bilinear;

static bilinear bilinear_at(double at, int n)
{
    const double x = fmin(fmax(at - 0.5, 0), n - 1);
    const int a = (int)x;

    return (bilinear){ a, a + 1 < n ? a + 1 : a, (float)(x - a) };
}

static void paint_row(const tile *t, const lt_image *from, int y, int first, int end, picture *to)
{
    const int64_t plane = (int64_t)to->size * to->size;
    const bilinear v = bilinear_at(source_y(t, y + 0.5), from->height);
    const uint8_t *above = from->data + (size_t)v.a * (size_t)from->width * 3;
    const uint8_t *below = from->data + (size_t)v.b * (size_t)from->width * 3;

    for (int x = first; x < end; x++) {
        const bilinear h = bilinear_at(source_x(t, x + 0.5), from->width);

        for (int c = 0; c < 3; c++) {
            const float a = (float)above[3 * h.a + c] + h.share * (float)(above[3 * h.b + c] - above[3 * h.a + c]);
            const float b = (float)below[3 * h.a + c] + h.share * (float)(below[3 * h.b + c] - below[3 * h.a + c]);

            to->image[c * plane + (int64_t)y * to->size + x] = (a + v.share * (b - a)) / 255;
        }
    }
}

/* Of a part of ours what the picture reaches */
static area reach(const tile *t, int width, int height)
{
    const double ends[2] = { t->tx, t->tx + width * t->sx };
    const area p = t->part;

    return (area){ fmax(p.x0, fmin(ends[0], ends[1])), fmax(p.y0, t->ty), fmin(p.x1, fmax(ends[0], ends[1])),
                   fmin(p.y1, t->ty + height * t->sy) };
}

static void paint(const tile *t, const lt_image *from, picture *to)
{
    const area r = reach(t, from->width, from->height);
    const int first = pixel(r.x0, to->size), end = pixel(r.x1, to->size);

    for (int y = pixel(r.y0, to->size); y < pixel(r.y1, to->size); y++)
        paint_row(t, from, y, first, end, to);
}

/* ---- its objects ---- */

static area box_of(const tile *t, const float box[4])
{
    const double x[2] = { box[0] * t->sx + t->tx, box[2] * t->sx + t->tx };

    return (area){ fmin(x[0], x[1]), box[1] * t->sy + t->ty, fmax(x[0], x[1]), box[3] * t->sy + t->ty };
}

static area cut(area a, area to)
{
    return (area){ fmax(a.x0, to.x0), fmax(a.y0, to.y0), fmin(a.x1, to.x1), fmin(a.y1, to.y1) };
}

static double size_of(area a)
{
    return a.x1 > a.x0 && a.y1 > a.y0 ? (a.x1 - a.x0) * (a.y1 - a.y0) : 0;
}

/* Around what is left of a mask that was cut off */
static area extent(const tile *t, const uint8_t *mask, const lt_image *of, area left)
{
    const double ends[2] = { source_x(t, left.x0), source_x(t, left.x1) };
    const int x0 = pixel(fmin(ends[0], ends[1]), of->width), x1 = pixel(fmax(ends[0], ends[1]), of->width);
    const int y0 = pixel(source_y(t, left.y0), of->height), y1 = pixel(source_y(t, left.y1), of->height);
    float box[4] = { (float)of->width, (float)of->height, 0, 0 };

    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++)
            if (mask[(size_t)y * (size_t)of->width + (size_t)x]) {
                box[0] = fminf(box[0], (float)x), box[2] = fmaxf(box[2], (float)x + 1);
                box[1] = fminf(box[1], (float)y), box[3] = fmaxf(box[3], (float)y + 1);
            }
    if (box[2] <= box[0])
        return (area){ 0, 0, 0, 0 };
    return cut(box_of(t, box), left);
}

/* The bits of the prototypes' cells whose centres are the object's */
static void draw_mask(const tile *t, const uint8_t *mask, const lt_image *of, area box, picture *to, int32_t *bits)
{
    const int side = to->size / PROTO_STRIDE;
    const int x0 = pixel(box.x0 / PROTO_STRIDE, side), x1 = pixel(box.x1 / PROTO_STRIDE, side);

    for (int y = pixel(box.y0 / PROTO_STRIDE, side); y < pixel(box.y1 / PROTO_STRIDE, side); y++)
        for (int x = x0; x < x1; x++) {
            const double u = source_x(t, (x + 0.5) * PROTO_STRIDE), v = source_y(t, (y + 0.5) * PROTO_STRIDE);
            const int at = y * side + x;

            if (u >= 0 && v >= 0 && u < of->width && v < of->height && mask[(size_t)v * (size_t)of->width + (size_t)u])
                bits[at / 32] = (int32_t)((uint32_t)bits[at / 32] | UINT32_C(1) << at % 32);
        }
}

static lt_status add_object(const tile *t, const detection_object *o, const lt_image *of, uint8_t *mask, picture *to)
{
    const area whole = box_of(t, o->box);
    area left = cut(whole, t->part);
    const bool has_mask = o->mask != DETECTION_NO_MASK;
    float *row = to->objects + to->n * OBJECT_NUMBERS;
    lt_status st = LT_OK;

    if (o->crowd || to->n == DETECT_MAX_OBJECTS || !size_of(left))
        return LT_OK;
    if (has_mask)
        st = detection_mask(o, of->width, of->height, mask);
    if (st)
        return st;
    if (has_mask && size_of(left) < size_of(whole))
        left = extent(t, mask, of, left);
    if (left.x1 - left.x0 < LEAST_SIDE || left.y1 - left.y0 < LEAST_SIDE
        || size_of(left) < LEAST_SHARE * size_of(whole))
        return LT_OK;
    row[OBJECT_CLASS] = (float)o->cls;
    row[OBJECT_X0] = (float)left.x0, row[OBJECT_Y0] = (float)left.y0;
    row[OBJECT_X1] = (float)left.x1, row[OBJECT_Y1] = (float)left.y1;
    row[OBJECT_HAS_MASK] = has_mask;
    if (has_mask)
        draw_mask(t, mask, of, left, to, to->masks + (size_t)to->n * (size_t)picture_words(to->size));
    to->n++;
    return LT_OK;
}

/* ---- putting it together ---- */

static void clear(picture *p)
{
    for (int64_t i = 0; i < (int64_t)3 * p->size * p->size; i++)
        p->image[i] = LETTERBOX_GREY;
    for (int i = 0; i < DETECT_MAX_OBJECTS * OBJECT_NUMBERS; i++)
        p->objects[i] = -1;
    memset(p->masks, 0, (size_t)DETECT_MAX_OBJECTS * (size_t)picture_words(p->size) * sizeof(*p->masks));
    p->n = 0;
}

static lt_status add_tile(const tile *t, const detection_sample *s, lt_arena *scratch, picture *out)
{
    uint8_t *mask = lt_arena_array(scratch, (size_t)s->rgb.width * (size_t)s->rgb.height, 1);
    lt_status st = mask ? LT_OK : lt_error(LT_ENOMEM, "no memory for masks");

    if (st == LT_OK)
        paint(t, &s->rgb, out);
    for (int i = 0; i < s->n && st == LT_OK; i++)
        st = add_object(t, &s->object[i], &s->rgb, mask, out);
    return st;
}

lt_status picture_plain(const detection_set *set, int64_t i, lt_arena *scratch, picture *out, int *width, int *height)
{
    detection_sample s;
    letterbox l;
    tile t;
    lt_status st = detection_read(set, i, scratch, &s);

    clear(out);
    if (st)
        return st;
    *width = s.rgb.width;
    *height = s.rgb.height;
    l = letterbox_of(s.rgb.width, s.rgb.height, out->size);
    t = (tile){ l.scale, l.scale, l.left, l.top, { 0, 0, out->size, out->size } };
    return add_tile(&t, &s, scratch, out);
}

/* A canvas's pixels become ours: they are scaled about its middle, which is moved, and maybe mirrored. */
typedef struct {
    double scale, x, y, middle;
    bool mirror;
} view;

static view draw_view(const detect_config *how, double middle, int size, lt_rng *rng)
{
    view v = { .middle = middle };

    v.scale = lt_rng_range(rng, 1 - how->scale, 1 + how->scale);
    v.x = size * lt_rng_range(rng, 0.5 - how->translate, 0.5 + how->translate);
    v.y = size * lt_rng_range(rng, 0.5 - how->translate, 0.5 + how->translate);
    v.mirror = lt_rng_uniform(rng) < how->flip;
    return v;
}

/* A picture at (x, y) of the canvas, `fit` as large as it is, inside part of the canvas */
static tile tile_of(const view *v, double fit, double x, double y, area part, int size)
{
    const double s = v->scale;
    tile t = { s * fit, s * fit, (x - v->middle) * s + v->x, (y - v->middle) * s + v->y,
               { (part.x0 - v->middle) * s + v->x, (part.y0 - v->middle) * s + v->y,
                 (part.x1 - v->middle) * s + v->x, (part.y1 - v->middle) * s + v->y } };

    if (v->mirror) {
        const double x0 = t.part.x0;

        t.sx = -t.sx;
        t.tx = size - t.tx;
        t.part.x0 = size - t.part.x1;
        t.part.x1 = size - x0;
    }
    t.part = cut(t.part, (area){ 0, 0, size, size });
    return t;
}

/* Four pictures that meet at a point of a canvas of twice the size; of each the corner that is there is seen. */
static lt_status add_mosaic(const detection_set *set, int64_t i, const detect_config *how, lt_rng *rng,
                            lt_arena *scratch, picture *out)
{
    const double S = out->size, cx = lt_rng_range(rng, S / 2, 1.5 * S), cy = lt_rng_range(rng, S / 2, 1.5 * S);
    const view v = draw_view(how, S, out->size, rng);
    lt_status st = LT_OK;

    for (int k = 0; k < TILES && st == LT_OK; k++) {
        const bool right = k % 2, low = k / 2;
        const area part = { right ? cx : 0, low ? cy : 0, right ? 2 * S : cx, low ? 2 * S : cy };
        detection_sample s;
        double fit;
        tile t;

        st = detection_read(set, k ? lt_rng_below(rng, (uint32_t)set->count) : i, scratch, &s);
        if (st)
            break;
        fit = fmin(S / s.rgb.width, S / s.rgb.height);
        t = tile_of(&v, fit, right ? cx : cx - s.rgb.width * fit, low ? cy : cy - s.rgb.height * fit, part, out->size);
        st = add_tile(&t, &s, scratch, out);
    }
    return st;
}

static lt_status add_single(const detection_set *set, int64_t i, const detect_config *how, lt_rng *rng,
                            lt_arena *scratch, picture *out)
{
    const view v = draw_view(how, out->size / 2.0, out->size, rng);
    detection_sample s;
    letterbox l;
    tile t;
    lt_status st = detection_read(set, i, scratch, &s);

    if (st)
        return st;
    l = letterbox_of(s.rgb.width, s.rgb.height, out->size);
    t = tile_of(&v, l.scale, l.left, l.top, (area){ 0, 0, out->size, out->size }, out->size);
    return add_tile(&t, &s, scratch, out);
}

lt_status picture_augmented(const detection_set *set, int64_t i, const detect_config *how, bool mosaic, lt_rng *rng,
                            lt_arena *scratch, picture *out)
{
    const bool four = lt_rng_uniform(rng) < how->mosaic && mosaic;
    lt_status st;

    clear(out);
    st = (four ? add_mosaic : add_single)(set, i, how, rng, scratch, out);
    if (st == LT_OK)
        augment_hsv(out->image, (int64_t)out->size * out->size, 1 + how->hue * lt_rng_range(rng, -1, 1),
                    1 + how->saturation * lt_rng_range(rng, -1, 1), 1 + how->value * lt_rng_range(rng, -1, 1));
    return st;
}
