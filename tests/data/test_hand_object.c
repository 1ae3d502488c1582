/* SPDX-License-Identifier: Apache-2.0 */
/* Sample preparation: every array of a batch against the map that made its crop. */
#include "data/hand_object.h"
#include "tests/suite.h"
#include "vision/crop.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { W = 640, H = 480, S = 64, CELLS = 8 };

static uint8_t *rgb, *silhouette;
static dataset_sample sample;

static void setup(void)
{
    rgb = malloc((size_t)W * H * 3);
    silhouette = calloc((size_t)W * H, 1);
    for (int i = 0; i < W * H * 3; i++)
        rgb[i] = (uint8_t)(i * 7 % 256);
    for (int y = 180; y < 260; y++)
        for (int x = 330; x < 420; x++)
            silhouette[y * W + x] = 1;
    sample = (dataset_sample){
        .name = "A/0", .width = W, .height = H, .rgb = rgb, .silhouette = silhouette,
        .flags = SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT | SAMPLE_OBJECT,
        .camera = { 610, 611, 320, 240 }, .object = 2, .root = { .1f, .2f, .6f }, .t = { 0, 0, 1 },
    };
    for (int i = 0; i < 21; i++) {
        sample.joints2d[i][0] = 250 + (float)(i * 37 % 100);
        sample.joints2d[i][1] = 190 + (float)(i * 53 % 90);
        sample.control2d[i][0] = 330 + (float)(i * 29 % 91);
        sample.control2d[i][1] = 180 + (float)(i * 31 % 81);
    }
    for (int i = 0; i < 16 * 9; i++)
        sample.rotation[i / 9][i % 9] = (float)(i % 7) - 3;
    for (int i = 0; i < 10; i++)
        sample.beta[i] = (float)i / 10;
}

static void teardown(void)
{
    free(rgb);
    free(silhouette);
}

static hand_object_options options(bool augment)
{
    hand_object_options o = hand_object_defaults(augment, 17);

    o.size = S;
    o.cells = CELLS;
    return o;
}

static hand_object_batch *prepare(const hand_object_options *o, uint64_t epoch, int64_t index, int slot)
{
    hand_object_batch *b = hand_object_batch_new(2, S, CELLS);

    ck_assert_ptr_nonnull(b);
    check_ok(hand_object_prepare(&sample, o, epoch, index, b, slot));
    return b;
}

static void map_of(const hand_object_batch *b, int slot, double A[6])
{
    for (int k = 0; k < 6; k++)
        A[k] = b->affine[6 * slot + k];
}

/* p in units of box is q mapped by A. */
static void same_place(const double A[6], const float *box, const float *p, const float *q)
{
    double m[2] = { q[0], q[1] };

    lt_affine_apply(A, m, m);
    ck_assert_double_eq_tol(box[0] + p[0] * (box[2] - box[0]), m[0], 2e-3);
    ck_assert_double_eq_tol(box[1] + p[1] * (box[3] - box[1]), m[1], 2e-3);
}

START_TEST(points_are_mapped)
{
    const hand_object_options o = options(_i);
    hand_object_batch *b = prepare(&o, 3, 9, 1);
    double A[6];

    map_of(b, 1, A);
    for (int i = 0; i < 21; i++) {
        same_place(A, b->hand_box + 4, b->joints2d + 42 + 2 * i, sample.joints2d[i]);
        same_place(A, b->object_box + 4, b->points2d + 42 + 2 * i, sample.control2d[i]);
    }
    ck_assert_float_eq(b->weight[1], 1);
    ck_assert_float_eq(b->weight[0], 0);
    ck_assert_float_eq(b->object_weight[1], 1);
    ck_assert_float_eq(b->object_weight[0], 0);
    ck_assert_int_eq(b->index[1], 9);
    ck_assert_int_eq(b->object[1], 2);
    ck_assert_mem_eq(b->beta + 10, sample.beta, sizeof(sample.beta));
    ck_assert_mem_eq(b->wrist + 3, sample.root, sizeof(sample.root));
    hand_object_batch_free(b);
}
END_TEST

START_TEST(hand_turns_with_the_crop)
{
    const hand_object_options o = options(true);
    hand_object_batch *b = prepare(&o, 0, 1, 0);
    const double phi = atan2(b->affine[3], b->affine[0]);
    const float *r = sample.rotation[0];

    ck_assert_double_gt(fabs(phi), 0.01);
    for (int j = 0; j < 3; j++) {
        ck_assert_double_eq_tol(b->rotation[j], cos(phi) * r[j] - sin(phi) * r[3 + j], 1e-4);
        ck_assert_double_eq_tol(b->rotation[3 + j], sin(phi) * r[j] + cos(phi) * r[3 + j], 1e-4);
        ck_assert_float_eq(b->rotation[6 + j], r[6 + j]);
    }
    ck_assert_mem_eq(b->rotation + 9, sample.rotation[1], 15 * 9 * sizeof(float));
    hand_object_batch_free(b);
}
END_TEST

/* Test crops: 7.3 by hand. Hand x 250 .. 349, y 190 .. 279; object x 330 .. 420, y 180 .. 260. */
START_TEST(test_crop)
{
    const hand_object_options o = options(false);
    hand_object_batch *b = prepare(&o, 0, 0, 0);
    const crop_box hand = crop_box_around(sample.joints2d, 21, 1.5);
    const crop_box object = crop_box_around(sample.control2d, 21, 1.5);
    const crop_window w = crop_window_around(hand, object, W, H);
    double A[6];
    crop_box pool;

    crop_affine(w, S, A);
    for (int k = 0; k < 6; k++)
        ck_assert_double_eq_tol(b->affine[k], A[k], 1e-4);
    pool = crop_corners(A, crop_box_around(sample.joints2d, 21, 1.1));
    ck_assert_float_eq_tol(b->hand_box[0], pool.x0, 1e-4);
    ck_assert_float_eq_tol(b->hand_box[3], pool.y1, 1e-4);
    for (int k = 0; k < 9; k++)
        ck_assert_float_eq_tol(b->K[k], k == 0 ? A[0] * 610 : k == 2 ? A[0] * 320 + A[2] : k == 4 ? A[4] * 611 :
                               k == 5 ? A[4] * 240 + A[5] : k == 8, 1e-2);
    for (int k = 0; k < CELLS * CELLS; k++)         /* the silhouette fills the object's box */
        ck_assert_float_eq(b->mask[k], 1);
    hand_object_batch_free(b);
}
END_TEST

START_TEST(annotated_box_is_taken)
{
    const hand_object_options o = options(false);
    const float corner[2][2] = { { 240, 170 }, { 360, 300 } };
    hand_object_batch *b;
    crop_box pool;
    double A[6];

    sample.flags = SAMPLE_ROOT | SAMPLE_HAND_BOX | SAMPLE_OBJECT;
    memcpy(sample.hand_box, corner, sizeof(corner));
    b = prepare(&o, 0, 0, 0);
    map_of(b, 0, A);
    pool = crop_corners(A, crop_box_around(corner, 2, 1.1));
    ck_assert_float_eq_tol(b->hand_box[0], pool.x0, 1e-3);
    ck_assert_float_eq_tol(b->hand_box[3], pool.y1, 1e-3);
    for (int k = 0; k < 42; k++)
        ck_assert_float_eq(b->joints2d[k], 0);
    hand_object_batch_free(b);
}
END_TEST

START_TEST(hand_alone)
{
    const hand_object_options o = options(true);
    hand_object_batch *b;

    sample.flags &= ~(unsigned)SAMPLE_OBJECT;
    b = prepare(&o, 0, 0, 0);
    ck_assert_int_eq(b->object[0], -1);
    ck_assert_float_eq(b->weight[0], 1);
    ck_assert_float_eq(b->object_weight[0], 0);
    for (int k = 0; k < CELLS * CELLS; k++)
        ck_assert_float_eq(b->mask[k], 0);
    hand_object_batch_free(b);
    sample.flags = SAMPLE_OBJECT;
    b = hand_object_batch_new(1, S, CELLS);
    ck_assert_int_eq(hand_object_prepare(&sample, &o, 0, 0, b, 0), LT_EFORMAT);
    ck_assert_str_eq(lt_last_error(), "A/0: has neither joints nor a hand box, so there is nothing to crop");
    hand_object_batch_free(b);
}
END_TEST

START_TEST(draws_are_keyed)
{
    const hand_object_options o = options(true);
    const size_t image = 3 * S * S, bytes = image * sizeof(float);
    hand_object_batch *a = prepare(&o, 2, 5, 0), *b = prepare(&o, 2, 5, 1);
    hand_object_batch *c = prepare(&o, 3, 5, 0), *d = prepare(&o, 2, 6, 0);

    ck_assert_mem_eq(a->image, b->image + image, bytes);
    ck_assert_mem_ne(a->image, c->image, bytes);
    ck_assert_mem_ne(a->image, d->image, bytes);
    hand_object_batch_free(a);
    hand_object_batch_free(b);
    hand_object_batch_free(c);
    hand_object_batch_free(d);
}
END_TEST

/* Hand and object are the left half of the image. */
static uint8_t left_half[16 * 12];

static void add_segments(void)
{
    for (int i = 0; i < 16 * 12; i++)
        left_half[i] = i % 16 < 4 ? SEGMENT_HAND : i % 16 < 8 ? SEGMENT_OBJECT : 0;
    sample.segments = left_half;
    sample.segments_width = 16;
    sample.segments_height = 12;
    sample.flags |= SAMPLE_SEGMENTS;
}

/* Without a mask, in a test crop, and without the option, nothing changes, and no mask is asked for in vain. */
START_TEST(background_only_where_asked_for)
{
    hand_object_options with = options(_i != 1), without = with;
    hand_object_batch *a, *b;

    with.background = _i == 2 ? 0 : 1;
    if (_i != 0)
        add_segments();
    a = prepare(&with, 1, 5, 0);
    b = prepare(&without, 1, 5, 0);
    ck_assert_mem_eq(a->image, b->image, 3 * S * S * sizeof(float));
    ck_assert_int_eq(!!(hand_object_want(&with) & SAMPLE_SEGMENTS), _i == 0);
    hand_object_batch_free(a);
    hand_object_batch_free(b);
}
END_TEST

/* All other draws stay what they were, and so do the pixels of hand and object. */
START_TEST(background_changes_nothing_else)
{
    hand_object_options with = options(true), without;
    hand_object_batch *a, *b;
    int same = 0, other = 0;
    double A[6], back[6];

    with.colour = (augment_limits){ 0 };
    without = with;
    with.background = 1;
    add_segments();
    sample.flags &= ~(unsigned)SAMPLE_HAND_POSE;                /* no forearm */
    a = prepare(&with, 1, 5, 0);
    b = prepare(&without, 1, 5, 0);
    ck_assert_mem_eq(a->affine, b->affine, 6 * sizeof(float));
    ck_assert_mem_eq(a->joints2d, b->joints2d, 42 * sizeof(float));
    ck_assert_mem_eq(a->mask, b->mask, CELLS * CELLS * sizeof(float));
    map_of(a, 0, A);
    ck_assert(lt_affine_inverse(A, back) == LT_OK);
    for (int i = 0; i < S * S; i++) {
        double p[2] = { i % S + 0.5, i / S + 0.5 };
        lt_affine_apply(back, p, p);
        if (p[0] > 60 && p[0] < W / 2 - 60 && p[1] > 60 && p[1] < H - 60)
            ck_assert_float_eq(a->image[i], b->image[i]);
        same += a->image[i] == b->image[i];
        other += p[0] > W / 2 + 60 && a->image[i] != b->image[i];
    }
    ck_assert_int_gt(same, S * S / 8);
    ck_assert_int_gt(other, S * S / 8);
    hand_object_batch_free(a);
    hand_object_batch_free(b);
}
END_TEST

START_TEST(background_by_chance)
{
    hand_object_options with = options(true), without = with;
    int replaced = 0;

    with.background = 0.3;
    add_segments();
    for (int i = 0; i < 200; i++) {
        hand_object_batch *a = prepare(&with, 1, i, 0), *b = prepare(&without, 1, i, 0), *c = prepare(&with, 1, i, 1);
        replaced += memcmp(a->image, b->image, 3 * S * S * sizeof(float)) != 0;
        ck_assert_mem_eq(a->image, c->image + 3 * S * S, 3 * S * S * sizeof(float));
        hand_object_batch_free(a);
        hand_object_batch_free(b);
        hand_object_batch_free(c);
    }
    ck_assert(replaced > 200 * 0.2 && replaced < 200 * 0.4);
}
END_TEST

START_TEST(jitter_keeps_its_limits)
{
    hand_object_options o = options(true);
    const crop_box hand = crop_box_around(sample.joints2d, 21, 1.5);
    const crop_box object = crop_box_around(sample.control2d, 21, 1.5);
    const crop_window w = crop_window_around(hand, object, W, H);
    int turned = 0;

    o.rotation = M_PI / 6;
    o.rotation_chance = 0.6;
    for (int i = 0; i < 400; i++) {
        hand_object_batch *b = prepare(&o, 0, i, 0);
        double A[6], back[6], c[2] = { S / 2.0, S / 2.0 }, phi;
        const double side = S / hypot(b->affine[0], b->affine[3]);
        map_of(b, 0, A);
        ck_assert(lt_affine_inverse(A, back) == LT_OK);
        lt_affine_apply(back, c, c);
        phi = atan2(A[3], A[0]);
        ck_assert(side >= 0.8 * w.side - 0.01 && side <= 1.2 * w.side + 0.01);
        ck_assert_double_le(fabs(c[0] - w.cx), 0.1 * w.side + 0.01);
        ck_assert_double_le(fabs(c[1] - w.cy), 0.1 * w.side + 0.01);
        ck_assert_double_le(fabs(phi), M_PI / 3 + 1e-4);
        turned += fabs(phi) > 1e-6;
        hand_object_batch_free(b);
    }
    ck_assert(turned > 400 * 0.52 && turned < 400 * 0.68);
}
END_TEST

/* The extent of all points as the crop sees it, in crop pixels: x0 y0 x1 y1. */
static void extent_in_crop(const hand_object_batch *b, double out[4])
{
    out[0] = out[1] = S;
    out[2] = out[3] = 0;
    for (int i = 0; i < 42; i++)
        for (int d = 0; d < 2; d++) {
            const double at = S * (double)(i < 21 ? b->joints2d[2 * i + d] : b->points2d[2 * (i - 21) + d]);

            out[d] = fmin(out[d], at);
            out[2 + d] = fmax(out[2 + d], at);
        }
}

/* Around everything: 15 pixels of the image on the long sides, 10 to 20 in training, and the crop for a box. */
START_TEST(union_of_both)
{
    const float whole[4] = { 0, 0, S, S };
    hand_object_options o = options(_i > 0);
    hand_object_batch *b;
    double e[4], pixels, left, right;

    o.crop = HAND_OBJECT_UNION;
    o.rotation = 0;
    b = prepare(&o, 0, _i, 0);
    ck_assert_mem_eq(b->hand_box, whole, sizeof(whole));
    ck_assert_mem_eq(b->object_box, whole, sizeof(whole));
    extent_in_crop(b, e);
    pixels = 1 / (double)b->affine[0];          /* of the image in one of the crop */
    left = e[0] * pixels;
    right = (S - e[2]) * pixels;
    if (_i == 0) {
        ck_assert_double_eq_tol(left, 15, 1e-3);
        ck_assert_double_eq_tol(right, 15, 1e-3);
    }
    ck_assert(left >= 10 - 1e-3 && left <= 20 + 1e-3 && right >= 10 - 1e-3 && right <= 20 + 1e-3);
    ck_assert_double_ge(e[1] * pixels, 10);
    hand_object_batch_free(b);
}
END_TEST

/* The middle of what is light in the crop, whose pixels' edges are whole numbers */
static void light_in_crop(const hand_object_batch *b, double out[2])
{
    double total = 0;

    out[0] = out[1] = 0;
    for (int y = 0; y < b->size; y++)
        for (int x = 0; x < b->size; x++) {
            const double light = b->image[y * b->size + x];

            total += light;
            out[0] += light * (x + 0.5);
            out[1] += light * (y + 0.5);
        }
    out[0] /= total;
    out[1] /= total;
}

/* One light pixel stands where the point of its place is mapped to. */
START_TEST(union_shows_points_where_they_are)
{
    enum { LARGE = 512 };
    hand_object_options o = options(false);
    hand_object_batch *b = hand_object_batch_new(1, LARGE, CELLS);
    const float *p = sample.joints2d[4];
    double A[6], light[2], at[2] = { p[0], p[1] };

    memset(rgb, 0, (size_t)W * H * 3);
    memset(rgb + 3 * ((int)p[1] * W + (int)p[0]), 255, 3);
    o.crop = HAND_OBJECT_UNION;
    o.size = LARGE;
    ck_assert_int_eq(hand_object_prepare(&sample, &o, 0, 0, b, 0), LT_OK);
    map_of(b, 0, A);
    lt_affine_apply(A, at, at);
    light_in_crop(b, light);
    ck_assert_double_eq_tol(light[0], at[0], 0.02 * A[0]);
    ck_assert_double_eq_tol(light[1], at[1], 0.02 * A[0]);
    hand_object_batch_free(b);
}
END_TEST

START_TEST(outside_is_grey_and_far)
{
    hand_object_options o = options(false);
    hand_object_batch *b;

    o.crop = HAND_OBJECT_UNION;
    o.depth = true;
    for (int i = 0; i < 21; i++)
        sample.joints2d[i][0] -= 250;           /* up to the image's edge: the margin lies beside it */
    b = prepare(&o, 0, 0, 0);
    ck_assert_float_eq(b->image[S * S / 2], 0.485f);
    ck_assert_float_eq(b->image[S * S + S * S / 2], 0.456f);
    for (int i = 0; i < S * S; i++)
        ck_assert_float_eq(b->depth[i], 1);
    hand_object_batch_free(b);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, setup, teardown);
    tcase_add_loop_test(c, points_are_mapped, 0, 2);
    tcase_add_test(c, hand_turns_with_the_crop);
    tcase_add_test(c, test_crop);
    tcase_add_test(c, annotated_box_is_taken);
    tcase_add_test(c, hand_alone);
    tcase_add_test(c, draws_are_keyed);
    tcase_add_loop_test(c, background_only_where_asked_for, 0, 3);
    tcase_add_test(c, background_changes_nothing_else);
    tcase_add_test(c, background_by_chance);
    tcase_add_test(c, jitter_keeps_its_limits);
    tcase_add_loop_test(c, union_of_both, 0, 20);
    tcase_add_test(c, union_shows_points_where_they_are);
    tcase_add_test(c, outside_is_grey_and_far);
}

int main(void)
{
    return run_suite("hand_object", add_tests);
}
