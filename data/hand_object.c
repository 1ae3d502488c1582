/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From a sample to a slot of a batch, and to the source of a loader of such batches. A sample is prepared in the order
 * of the parents' code: a window around hand and object, jittered and turned; the picture in it, its background and
 * colours changed; boxes to pool from; points in units of these, and rotations turned with the window.
 */
#include "data/hand_object.h"

#include "data/background.h"
#include "libtensor/geometry/box21.h"
#include "vision/crop.h"
#include "vision/depth.h"

#include <math.h>
#include <string.h>

/* How much larger than its points a box is: to crop, and to pool features from. */
static const double HAND_CROP = 1.5, OBJECT_CROP = 1.5, HAND_POOL = 1.1, OBJECT_POOL = 1.0;

/* Around everything: pixels on each side in training and otherwise; what is outside of the image. */
static const double MARGIN_LOW = 10, MARGIN_HIGH = 20, MARGIN = 15;
static const float MEAN_COLOUR[3] = { 0.485f, 0.456f, 0.406f };

enum { MOST_POINTS = LT_HAND_KEYPOINTS };                   /* of hand or object */
_Static_assert((int)LT_BOX_POINTS <= (int)MOST_POINTS, "points of either are mapped into the same room");

enum { STREAM = 0x484f4341, BACKGROUND = 0x42414b47 };      /* tell these draws apart from other uses of the seed */

hand_object_options hand_object_defaults(bool augment, uint64_t seed)
{
    return (hand_object_options){
        .size = 256, .cells = 32, .seed = seed, .augment = augment,
        .centre_jitter = 0.1, .scale_jitter = 0.2, .rotation = M_PI, .rotation_chance = 1,
        .colour = { .blur = 0.5, .brightness = 0.5, .contrast = 0.5, .saturation = 0.5, .hue = 0.15 },
    };
}

/* ---- one sample ---- */

/* The points that the hand's boxes are drawn around. */
typedef struct { float p[LT_HAND_KEYPOINTS][2]; int n; } hand_points;

static hand_points hand_points_of(const dataset_sample *s, bool augment)
{
    hand_points h = { .n = 2, .p = { { s->hand_box[0], s->hand_box[1] },
                                     { s->hand_box[2], s->hand_box[3] } } };

    if ((s->flags & SAMPLE_JOINTS) && (augment || !(s->flags & SAMPLE_HAND_BOX))) {
        h.n = LT_HAND_KEYPOINTS;
        memcpy(h.p, s->joints2d, sizeof(h.p));
    }
    return h;
}

static bool has_object(const dataset_sample *s)
{
    return s->flags & SAMPLE_OBJECT;
}

static double draw_angle(const hand_object_options *o, lt_rng *rng)
{
    const double chance = lt_rng_uniform(rng), uniform = lt_rng_range(rng, -1, 1);
    const double normal = lt_rng_normal(rng);

    if (o->rotation_chance >= 1)
        return uniform * o->rotation;
    return chance < o->rotation_chance ? fmax(-2, fmin(2, normal)) * o->rotation : 0;
}

static void include(crop_box *b, crop_box other)
{
    b->x0 = fminf(b->x0, other.x0);
    b->y0 = fminf(b->y0, other.y0);
    b->x1 = fmaxf(b->x1, other.x1);
    b->y1 = fmaxf(b->y1, other.y1);
}

/* Each side of the box around all points moves outward on its own. */
static crop_window union_window(const dataset_sample *s, const hand_object_options *o, const hand_points *hand,
                                lt_rng *rng)
{
    crop_box b = crop_extent(hand->p, hand->n);
    float *const side[4] = { &b.x0, &b.y0, &b.x1, &b.y1 };
    crop_window w;

    if (has_object(s))
        include(&b, crop_extent(s->control2d, LT_BOX_POINTS));
    for (int i = 0; i < 4; i++) {
        const double out = o->augment ? lt_rng_range(rng, MARGIN_LOW, MARGIN_HIGH) : MARGIN;
        *side[i] += (float)(i < 2 ? -out : out);
    }
    w = crop_window_hull(b);
    w.angle = o->augment ? draw_angle(o, rng) : 0;
    return w;
}

/* The window around hand and object, moved, scaled and turned. */
static crop_window choose_window(const dataset_sample *s, const hand_object_options *o,
                                 const hand_points *hand, lt_rng *rng)
{
    const crop_box h = crop_box_around(hand->p, hand->n, HAND_CROP);
    const crop_box b = has_object(s) ? crop_box_around(s->control2d, LT_BOX_POINTS, OBJECT_CROP) : h;
    crop_window w = crop_window_around(h, b, s->width, s->height);

    if (o->augment) {
        const double dx = lt_rng_range(rng, -1, 1), dy = lt_rng_range(rng, -1, 1);
        const double scale = 1 + o->scale_jitter * lt_rng_normal(rng);
        w.cx += o->centre_jitter * w.side * dx;
        w.cy += o->centre_jitter * w.side * dy;
        w.side *= fmax(1 - o->scale_jitter, fmin(1 + o->scale_jitter, scale));
        w.angle = draw_angle(o, rng);
    }
    return w;
}

/* How pixels go to the crop where points go by A. In an image's points whole numbers are the centres of pixels, in a
 * warp their edges. Semi-Hand-Object and HFL-Net, whose crop is the one around boxes, take the two for one. */
static void picture_map(const hand_object_options *o, const double A[6], double out[6])
{
    const double half = o->crop == HAND_OBJECT_UNION ? 0.5 : 0;

    memcpy(out, A, 6 * sizeof(*out));
    out[2] -= half * (A[0] + A[1]);
    out[5] -= half * (A[3] + A[4]);
}

static crop_box whole_crop(int size)
{
    return (crop_box){ 0, 0, (float)size, (float)size };
}

/* To pool features from: in training around the mapped points, else around the image's points and then mapped. */
static crop_box pool_box(const hand_object_options *o, const double A[6], const float (*p)[2], int n, double factor)
{
    float mapped[MOST_POINTS][2];

    if (o->crop == HAND_OBJECT_UNION)
        return whole_crop(o->size);
    if (!o->augment)
        return crop_corners(A, crop_box_around(p, n, factor));
    crop_points(A, p, n, mapped);
    return crop_box_around(mapped, n, factor);
}

static void store_box(float *out, crop_box b)
{
    out[0] = b.x0;
    out[1] = b.y0;
    out[2] = b.x1;
    out[3] = b.y1;
}

/* Points of the image in units of box. */
static void store_points(const double A[6], const float (*p)[2], int n, crop_box box, float *out)
{
    float mapped[MOST_POINTS][2];

    crop_points(A, p, n, mapped);
    crop_normalise(box, mapped, n, (float (*)[2])out);
}

/* As the window turns, so does the hand: R_0 <- Rz(angle) R_0, and the other joints with it. */
static void store_rotations(const dataset_sample *s, double angle, float *out)
{
    const double c = cos(angle), n = sin(angle);
    const float *r = s->rotation[0];

    memcpy(out, s->rotation, sizeof(s->rotation));
    for (int j = 0; j < 3; j++) {
        out[j] = (float)(c * r[j] - n * r[3 + j]);
        out[3 + j] = (float)(n * r[j] + c * r[3 + j]);
    }
}

static void store_hand(const dataset_sample *s, const hand_object_options *o, const double A[6],
                       double angle, const hand_points *hand, hand_object_batch *b, size_t i)
{
    const crop_box box = pool_box(o, A, hand->p, hand->n, HAND_POOL);

    store_box(b->hand_box + 4 * i, box);
    if (s->flags & SAMPLE_JOINTS) {
        store_points(A, s->joints2d, LT_HAND_KEYPOINTS, box, b->joints2d + 2 * LT_HAND_KEYPOINTS * i);
        memcpy(b->joints + 3 * LT_HAND_KEYPOINTS * i, s->joints, sizeof(s->joints));
    }
    if (s->flags & SAMPLE_HAND_POSE) {
        store_rotations(s, angle, b->rotation + 9 * LT_HAND_JOINTS * i);
        memcpy(b->beta + LT_HAND_BETAS * i, s->beta, sizeof(s->beta));
    }
    memcpy(b->wrist + 3 * i, s->root, sizeof(s->root));
    b->vertices[i] = s->vertices;
}

static void store_object(const dataset_sample *s, const hand_object_options *o, const double A[6],
                         const double picture[6], hand_object_batch *b, size_t i)
{
    const crop_box box = pool_box(o, A, s->control2d, LT_BOX_POINTS, OBJECT_POOL);
    const size_t cells = (size_t)b->cells * (size_t)b->cells;

    store_box(b->object_box + 4 * i, box);
    store_points(A, s->control2d, LT_BOX_POINTS, box, b->points2d + 2 * LT_BOX_POINTS * i);
    memcpy(b->R + 9 * i, s->R, sizeof(s->R));
    memcpy(b->t + 3 * i, s->t, sizeof(s->t));
    b->object[i] = s->object;
    if (s->silhouette)
        crop_mask(picture, s->silhouette, s->width, s->height, b->size, box, b->mask + cells * i, b->cells);
}

/* By draws of its own, so that all others are what they are without. */
static void replace_background(const dataset_sample *s, const hand_object_options *o, const double A[6],
                               uint64_t epoch, int64_t index, float *image, float *scratch)
{
    lt_rng rng = lt_rng_make(o->seed, lt_rng_mix(lt_rng_mix(BACKGROUND, epoch), (uint64_t)index));

    if (!o->augment || !(s->flags & SAMPLE_SEGMENTS) || lt_rng_uniform(&rng) >= o->background)
        return;
    background_keep(s, A, scratch, o->size);
    background_draw(scratch, o->size, &rng, image);
}

static void store_picture(const dataset_sample *s, const hand_object_options *o, const double A[6], lt_rng *rng,
                          uint64_t epoch, int64_t index, hand_object_batch *b, size_t i)
{
    const size_t pixels = (size_t)b->size * (size_t)b->size;
    const bool all = o->crop == HAND_OBJECT_UNION;
    float *image = b->image + 3 * pixels * i, *scratch = b->scratch + pixels * i;

    crop_warp(A, s->rgb, s->width, s->height, all ? MEAN_COLOUR : NULL, image, b->size, all || o->bilinear);
    replace_background(s, o, A, epoch, index, image, scratch);
    if (o->augment)
        augment_colour(image, b->size, b->size, &o->colour, rng, scratch);
    if (o->depth)
        depth_crop(A, s->depth, s->silhouette, s->width, s->height, b->metres + pixels * i, b->depth + pixels * i,
                   b->size, scratch);
}

static void store_sample(const dataset_sample *s, const hand_object_options *o, uint64_t epoch, int64_t index,
                         hand_object_batch *b, size_t i)
{
    lt_rng rng = lt_rng_make(o->seed, lt_rng_mix(lt_rng_mix(STREAM, epoch), (uint64_t)index));
    const hand_points hand = hand_points_of(s, o->augment);
    const crop_window w = o->crop == HAND_OBJECT_UNION ? union_window(s, o, &hand, &rng)
                                                       : choose_window(s, o, &hand, &rng);
    double A[6], picture[6];

    crop_affine(w, b->size, A);
    picture_map(o, A, picture);
    store_picture(s, o, picture, &rng, epoch, index, b, i);
    for (int k = 0; k < 6; k++)
        b->affine[6 * i + (size_t)k] = (float)A[k];
    crop_intrinsics(A, &s->camera, b->K + 9 * i);
    store_hand(s, o, A, w.angle, &hand, b, i);
    if (has_object(s))
        store_object(s, o, A, picture, b, i);
    b->flags[i] = s->flags;
    b->weight[i] = 1;
    b->object_weight[i] = has_object(s);
}

lt_status hand_object_prepare(const dataset_sample *s, const hand_object_options *o,
                              uint64_t epoch, int64_t index, hand_object_batch *b, int slot)
{
    if (!(s->flags & (SAMPLE_JOINTS | SAMPLE_HAND_BOX)))
        return lt_error(LT_EFORMAT, "%s: has neither joints nor a hand box, so there is nothing to crop",
                        s->name);
    hand_object_batch_clear(b, slot, index);
    store_sample(s, o, epoch, index, b, (size_t)slot);
    return LT_OK;
}

/* ---- what the loader calls ---- */

unsigned hand_object_want(const hand_object_options *o)
{
    const bool segments = o->augment && o->background > 0;

    return SAMPLE_OBJECT | (o->depth ? SAMPLE_DEPTH : 0) | (segments ? SAMPLE_SEGMENTS : 0);
}

static int64_t sample_of(const hand_object_feed *f, int64_t i)
{
    return f->index ? f->index[i] : i;
}

static const char *source_name(const void *ctx, int64_t index)
{
    const hand_object_feed *f = ctx;

    return dataset_name(f->data, sample_of(f, index));
}

static void *source_batch_new(const void *ctx, int capacity)
{
    const hand_object_feed *f = ctx;

    return hand_object_batch_new(capacity, f->options.size, f->options.cells);
}

static void source_batch_free(void *batch)
{
    hand_object_batch_free(batch);
}

static void source_start(void *batch, int count)
{
    ((hand_object_batch *)batch)->count = count;
}

static lt_status source_fill(const void *ctx, uint64_t epoch, int64_t index, lt_arena *scratch, void *batch,
                             int slot)
{
    const hand_object_feed *f = ctx;
    const int64_t sample = sample_of(f, index);
    dataset_sample s;
    const lt_status st = dataset_read(f->data, sample, hand_object_want(&f->options), scratch, &s);

    return st ? st : hand_object_prepare(&s, &f->options, epoch, sample, batch, slot);
}

static void source_skip(void *batch, int slot, int64_t index)
{
    hand_object_batch_clear(batch, slot, index);
}

loader_source hand_object_source(const hand_object_feed *feed)
{
    return (loader_source){
        .ctx = feed, .count = feed->index ? feed->count : feed->data->count, .name = source_name,
        .batch_new = source_batch_new, .batch_free = source_batch_free,
        .start = source_start, .fill = source_fill, .skip = source_skip,
    };
}
