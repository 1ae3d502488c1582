/* SPDX-License-Identifier: Apache-2.0 */
/*
 * HO3D's rendered segmentations. Version 2 has the hand red and the object blue, in JPEGs; version 3 the hand blue and
 * the object green, in PNGs; copies are saved anew as the other. Which of the two a tree has is seen over some frames:
 * a mask that has only blue in it would be either.
 *
 * Source: HOISDF data/ho3d.py for version 2; ru1ven/ArGS dataset/ho3d_seg.py for version 3.
 */
#include "data/ho3d/internal.h"

#include "vision/picture.h"

#include <string.h>
#include <strings.h>
#include <unistd.h>

enum { RED, GREEN, BLUE, CHANNELS };
enum { LOOKED_AT = 50 };        /* frames */
enum { LEVEL = 200 };           /* a JPEG's edges ring, so that no lower one is safe */

/* What is seen of a tree's masks. */
typedef struct {
    int64_t masks, jpeg;
    bool has[CHANNELS];
    int64_t joints[CHANNELS];   /* of hands, that lie on the colour */
} evidence;

static void look_at_pixels(const lt_image *mask, evidence *e)
{
    for (size_t i = 0; i < lt_image_bytes(mask); i++)
        e->has[i % CHANNELS] |= mask->data[i] > LEVEL;
}

static void look_at_joints(const dataset_sample *s, const lt_image *mask, evidence *e)
{
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++) {
        const double u = s->joints2d[i][0] + 0.5, v = s->joints2d[i][1] + 0.5;
        const uint8_t *rgb;

        if (!(u >= 0 && u < s->width && v >= 0 && v < s->height))
            continue;
        rgb = mask->data + CHANNELS * ((size_t)(v * mask->height / s->height) * (size_t)mask->width +
                                       (size_t)(u * mask->width / s->width));
        for (int c = 0; c < CHANNELS; c++)
            e->joints[c] += rgb[c] > LEVEL;
    }
}

/* A frame that cannot be read is passed over: whoever reads it is told. */
static void look_at(const ho3d *h, int64_t index, lt_arena *arena, evidence *e)
{
    const char *path = ho3d_picture(h, index, arena, "seg");
    dataset_sample s;
    lt_image mask;

    if (!path || access(path, F_OK) || picture_read_mask(arena, path, h->width, h->height, &mask))
        return;
    e->masks++;
    e->jpeg += strcasecmp(strrchr(path, '.'), ".png") != 0;
    look_at_pixels(&mask, e);
    if (!ho3d_read_annotation(&h->base, index, arena, &s) && (s.flags & SAMPLE_JOINTS) &&
        !dataset_project(&h->base, &s))
        look_at_joints(&s, &mask, e);
}

/* Red is nobody's in version 3, and green nobody's in version 2, though there it may be the arm's. */
static ho3d_mask_colours colours_of(const evidence *e)
{
    const bool second = e->has[RED] || (!e->has[GREEN] && 2 * e->jpeg > e->masks);
    ho3d_mask_colours c = { .known = true, .hand = second ? RED : BLUE, .object = second ? BLUE : GREEN };

    c.joints_on_hand = e->joints[c.hand];
    c.joints_on_object = e->joints[c.object];
    return c;
}

static lt_status find_colours(const ho3d *h, ho3d_mask_colours *out)
{
    const int64_t n = h->base.count < LOOKED_AT ? h->base.count : LOOKED_AT;
    evidence e = { 0 };

    for (int64_t i = 0; i < n; i++) {
        lt_arena *arena = lt_arena_new();

        if (!arena)
            return lt_error(LT_ENOMEM, "%s: no memory", h->base.root);
        look_at(h, i * h->base.count / n, arena, &e);
        lt_arena_free(arena);
    }
    *out = colours_of(&e);
    return LT_OK;
}

/* Joints are behind the object now and then, but not most of the time. */
static lt_status check_colours(const ho3d *h, const ho3d_mask_colours *c)
{
    if (c->joints_on_object <= c->joints_on_hand || c->joints_on_object < LT_HAND_KEYPOINTS)
        return LT_OK;
    return lt_error(LT_EFORMAT, "%s/%s: the masks in SEQUENCE/seg have %lld joints of hands on the object and %lld on "
                    "the hand, expected the hand red and the object blue, as HO3D v2 has them, or the hand blue and "
                    "the object green, as v3", h->base.root, h->base.split, (long long)c->joints_on_object,
                    (long long)c->joints_on_hand);
}

/* The first who asks for a mask looks; the others wait. */
static lt_status tree_colours(const ho3d *h, ho3d_mask_colours *out)
{
    ho3d_masks *m = (ho3d_masks *)&h->masks;            /* a cache: what is in it does not change what h is */
    lt_status st = LT_OK;

    pthread_mutex_lock(&m->lock);
    if (!m->colours.known)
        st = find_colours(h, &m->colours);
    *out = m->colours;
    pthread_mutex_unlock(&m->lock);
    return st ? st : check_colours(h, out);
}

static uint8_t label_of(const uint8_t rgb[CHANNELS], const ho3d_mask_colours *c)
{
    if (rgb[c->hand] > LEVEL)
        return SEGMENT_HAND;
    return rgb[c->object] > LEVEL ? SEGMENT_OBJECT : 0;
}

lt_status ho3d_read_segments(const ho3d *h, int64_t index, lt_arena *arena, dataset_sample *s)
{
    const char *path = ho3d_picture(h, index, arena, "seg");
    ho3d_mask_colours c;
    lt_image mask;
    uint8_t *label;
    lt_status st;

    if (!path)
        return lt_error(LT_ENOMEM, "%s: no memory", h->name[index]);
    if (access(path, F_OK))
        return LT_OK;
    st = picture_read_mask(arena, path, h->width, h->height, &mask);
    if (!st)
        st = tree_colours(h, &c);
    if (!st)
        st = lt_arena_try(arena, lt_image_bytes(&mask) / CHANNELS, (void **)&label);
    if (st)
        return st;
    for (size_t i = 0; i < lt_image_bytes(&mask) / CHANNELS; i++)
        label[i] = label_of(mask.data + CHANNELS * i, &c);
    s->segments = label;
    s->segments_width = mask.width;
    s->segments_height = mask.height;
    s->flags |= SAMPLE_SEGMENTS;
    return LT_OK;
}
