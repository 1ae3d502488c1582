/* SPDX-License-Identifier: Apache-2.0 */
/* Backgrounds: what stays of a picture, and what is drawn around it. */
#include "data/background.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { W = 640, H = 480, MW = 160, MH = 120, S = 64 };

static uint8_t mask[MW * MH];
static float keep[4 * S * S], image[3 * 4 * S * S];

/* Hand and object, side by side, are x 160 .. 319, y 120 .. 359 of the image; the pose of the hand is unknown. */
static dataset_sample sample_of(void)
{
    for (int i = 0; i < MW * MH; i++)
        mask[i] = i / MW < 30 || i / MW >= 90 || i % MW < 40 || i % MW >= 80 ? 0
                  : i % MW < 60 ? SEGMENT_HAND : SEGMENT_OBJECT;
    return (dataset_sample){
        .width = W, .height = H, .camera = { 600, 600, 320, 240 }, .flags = SAMPLE_JOINTS | SAMPLE_SEGMENTS,
        .segments = mask, .segments_width = MW, .segments_height = MH,
        .joints = { { 0.1f, 0, 0.6f } }, .rotation = { { 1, 0, 0, 0, 1, 0, 0, 0, 1 } },
    };
}

/* Ten image pixels to one of the crop, whose last rows lie outside of the image. */
static const double A[6] = { 0.1, 0, 0, 0, 0.1, 0 };

static float kept(int x, int y)
{
    return keep[y * S + x];
}

START_TEST(mask_is_smooth)
{
    const dataset_sample s = sample_of();

    background_keep(&s, A, keep, S);
    for (int y = 0; y < S; y++)
        for (int x = 0; x < S; x++) {
            ck_assert(kept(x, y) >= 0 && kept(x, y) <= 1);
            if (x >= 17 && x < 31 && y >= 13 && y < 35)
                ck_assert_float_eq(kept(x, y), 1);
            if (x < 15 || x > 32 || y < 11 || y > 36)
                ck_assert_float_eq(kept(x, y), 0);
        }
}
END_TEST

/* Across the edge at 160, a crop pixel an image pixel: never falling, half at the edge, within a cell of the mask. */
START_TEST(edge_is_soft)
{
    const double at_edge[6] = { 1, 0, -160 + S / 2, 0, 1, -200 };
    const dataset_sample s = sample_of();
    int between = 0;

    background_keep(&s, at_edge, keep, S);
    for (int x = 1; x < S; x++) {
        ck_assert_float_ge(kept(x, 9), kept(x - 1, 9));
        between += kept(x, 9) > 0 && kept(x, 9) < 1;
    }
    ck_assert_float_eq_tol((kept(S / 2 - 1, 9) + kept(S / 2, 9)) / 2, 0.5f, 1e-6);
    ck_assert(between >= 2 && between <= 4);
}
END_TEST

/* From the wrist at (420, 240), 34 mm and more to each side, to the image's right edge and beyond. */
START_TEST(forearm_stays)
{
    dataset_sample s = sample_of();

    s.flags |= SAMPLE_HAND_POSE;
    background_keep(&s, A, keep, S);
    for (int x = 42; x < S; x++)
        ck_assert_float_eq(kept(x, 24), 1);
    for (int x = 0; x < 38; x++)
        ck_assert_float_eq(kept(x, 5), 0);
    ck_assert_float_eq(kept(60, 28), 1);
    ck_assert_float_eq(kept(60, 31), 0);
    ck_assert_float_eq(kept(60, 17), 0);
    ck_assert_float_eq(kept(36, 24), 0);
}
END_TEST

/* It ends before the camera, where its width would have none. */
START_TEST(forearm_towards_the_camera)
{
    dataset_sample s = sample_of();

    s.flags |= SAMPLE_HAND_POSE;
    memset(s.rotation[0], 0, sizeof(s.rotation[0]));
    s.rotation[0][6] = -1;
    background_keep(&s, A, keep, S);
    for (int i = 0; i < S * S; i++)
        ck_assert(keep[i] >= 0 && keep[i] <= 1);
    ck_assert_float_eq(kept(50, 24), 1);
}
END_TEST

/* ---- pictures ---- */

static void draw(uint64_t stream, int size)
{
    lt_rng rng = lt_rng_make(5, stream);

    background_draw(keep, size, &rng, image);
}

static void keep_all(float share, int size)
{
    for (int i = 0; i < size * size; i++)
        keep[i] = share;
}

/* Picture number stream on its own, in memory of the caller's. */
static float *picture(uint64_t stream, int size)
{
    float *out = malloc(sizeof(image));

    keep_all(0, size);
    memset(image, 0, sizeof(image));
    draw(stream, size);
    return memcpy(out, image, sizeof(image));
}

START_TEST(drawn_by_number)
{
    float *a = picture(1, S), *b = picture(1, S), *c = picture(2, S);
    double first = 0, other = 0;

    ck_assert_mem_eq(a, b, sizeof(image));
    for (int i = 0; i < 3 * S * S; i++) {
        ck_assert(a[i] >= 0 && a[i] <= 1);
        first += a[i];
        other += c[i];
    }
    ck_assert_double_gt(fabs(first - other), 3 * S * S * 0.01);
    free(a);
    free(b);
    free(c);
}
END_TEST

START_TEST(mixed_in_its_share)
{
    float *drawn = picture(3, S);

    for (int i = 0; i < S * S; i++)
        keep[i] = (float)(i % 3) / 2;
    for (int i = 0; i < 3 * S * S; i++)
        image[i] = 0.25f;
    draw(3, S);
    for (int i = 0; i < 3 * S * S; i++) {
        const float share = (float)(i % (S * S) % 3) / 2;
        if (share == 1)
            ck_assert_float_eq(image[i], 0.25f);
        ck_assert_float_eq_tol(image[i], share * 0.25f + (1 - share) * drawn[i], 1e-6);
    }
    free(drawn);
}
END_TEST

/* What a larger crop shows, a smaller one does: but for the grain, and pixels on which an edge falls. */
START_TEST(any_size)
{
    float *small = picture(4 + (uint64_t)_i, S), *large = picture(4 + (uint64_t)_i, 2 * S);
    int near = 0;

    for (int y = 0; y < S; y++)
        for (int x = 0; x < S; x++) {
            const float *p = &large[2 * (2 * S * y + x)];
            near += fabsf(small[y * S + x] - (p[0] + p[1] + p[2 * S] + p[2 * S + 1]) / 4) < 0.1f;
        }
    ck_assert_int_ge(near, S * S * 7 / 10);
    free(small);
    free(large);
}
END_TEST

/* Few are alike: mean colours are spread over most of the cube. */
START_TEST(they_differ)
{
    enum { N = 100 };
    double sum[3] = { 0 }, square[3] = { 0 };

    for (uint64_t n = 0; n < N; n++) {
        float *p = picture(100 + n, 16);
        for (int c = 0; c < 3; c++) {
            double mean = 0;
            for (int i = 0; i < 16 * 16; i++)
                mean += p[c * 16 * 16 + i] / (16 * 16.0);
            sum[c] += mean / N;
            square[c] += mean * mean / N;
        }
        free(p);
    }
    for (int c = 0; c < 3; c++) {
        ck_assert(sum[c] > 0.3 && sum[c] < 0.6);
        ck_assert_double_gt(sqrt(square[c] - sum[c] * sum[c]), 0.12);
    }
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_test(c, mask_is_smooth);
    tcase_add_test(c, edge_is_soft);
    tcase_add_test(c, forearm_stays);
    tcase_add_test(c, forearm_towards_the_camera);
    tcase_add_test(c, drawn_by_number);
    tcase_add_test(c, mixed_in_its_share);
    tcase_add_loop_test(c, any_size, 0, 8);
    tcase_add_test(c, they_differ);
}

int main(void)
{
    return run_suite("background", add_tests);
}
