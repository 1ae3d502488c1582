/* SPDX-License-Identifier: Apache-2.0 */
/* Letterboxes, boxes and masks out of a detector's maps, beside the plain formulas. */
#include "libtensor/base/rng.h"
#include "tests/suite.h"
#include "vision/detection/detection.h"

#include <math.h>

enum { SIZE = 64, NC = 3, SIDE = SIZE / 4, CELLS = 64 };

static lt_arena *arena;
static float box[DETECTION_LEVELS][64 * CELLS], cls[DETECTION_LEVELS][NC * CELLS], mask[DETECTION_LEVELS][32 * CELLS];
static float proto[32 * SIDE * SIDE];
static const detection_maps maps = {
    .size = SIZE, .classes = NC, .box = { box[0], box[1], box[2] }, .cls = { cls[0], cls[1], cls[2] },
    .mask = { mask[0], mask[1], mask[2] }, .proto = proto,
};

static void setup(void)
{
    lt_rng r = lt_rng_make(3, 0);

    arena = lt_arena_new();
    for (int i = 0; i < 32 * SIDE * SIDE; i++)
        proto[i] = (float)lt_rng_range(&r, -1, 1);
    for (int l = 0; l < DETECTION_LEVELS; l++) {
        for (int i = 0; i < NC * CELLS; i++)
            cls[l][i] = -9;
        for (int i = 0; i < 32 * CELLS; i++)
            mask[l][i] = (float)lt_rng_range(&r, -1, 1);
        memset(box[l], 0, sizeof(box[l]));
    }
}

static void teardown(void)
{
    lt_arena_free(arena);
}

static int plane(int level)
{
    return CELLS >> 2 * level;
}

/* Let a cell see a box whose sides are this far, in whole cells */
static void see(int level, int at, int c, float logit, const int far[4])
{
    cls[level][c * plane(level) + at] = logit;
    for (int s = 0; s < 4; s++)
        box[level][(s * 16 + far[s]) * plane(level) + at] = 100;
}

START_TEST(boxes)
{
    static const int far[] = { 1, 2, 3, 1 };
    detection *found;
    int n;

    see(0, 3 * 8 + 2, 1, 2, far);               /* the centre is 20, 28 */
    see(1, 1 * 4 + 1, 2, 0, far);               /* 24, 24 */
    check_ok(detection_find(arena, &maps, &detection_rules_shown, &found, &n));
    ck_assert_int_eq(n, 2);
    ck_assert_int_eq(found[0].cls, 1);
    ck_assert_float_eq_tol(found[0].score, 1 / (1 + expf(-2)), 1e-6f);
    ck_assert_float_eq_tol(found[0].box[0], 12, 1e-3f);
    ck_assert_float_eq_tol(found[0].box[1], 12, 1e-3f);
    ck_assert_float_eq_tol(found[0].box[2], 44, 1e-3f);
    ck_assert_float_eq_tol(found[0].box[3], 36, 1e-3f);
    ck_assert_float_eq_tol(found[1].box[0], 8, 1e-3f);
    ck_assert_float_eq(found[1].coefficient[5], mask[1][5 * 16 + 5]);
}
END_TEST

/* Of one class the surer one alone; another class, or one that overlaps less, stays. */
START_TEST(the_surest_alone)
{
    static const int far[] = { 3, 3, 3, 3 };
    detection *found;
    int n;

    see(0, 3 * 8 + 3, 1, 1, far);
    see(0, 3 * 8 + 4, 1, 2, far);               /* 5 x 6 of 7 x 6 cells: 5 / 7 */
    see(0, 4 * 8 + 3, 2, 3, far);
    see(0, 6 * 8 + 6, 1, 0, far);
    check_ok(detection_find(arena, &maps, &detection_rules_shown, &found, &n));
    ck_assert_int_eq(n, 3);
    ck_assert_int_eq(found[0].cls, 2);
    ck_assert_float_eq_tol(found[1].box[0], 36 - 24, 1e-3f);
    ck_assert_float_eq_tol(found[2].score, 0.5f, 1e-6f);
}
END_TEST

START_TEST(every_class_of_a_cell)
{
    static const int far[] = { 1, 1, 1, 1 };
    const detection_rules two = { .score = 0.001, .iou = 0.7, .most = 2, .every_class = true };
    detection *found;
    int n;

    see(2, 0, 0, 1, far);
    see(2, 0, 2, 2, far);
    check_ok(detection_find(arena, &maps, &detection_rules_shown, &found, &n));
    ck_assert_int_eq(n, 1);
    check_ok(detection_find(arena, &maps, &two, &found, &n));
    ck_assert_int_eq(n, 2);
    ck_assert_int_eq(found[1].cls, 0);
}
END_TEST

/* As pycocotools takes so many of each class in an image: what is found of one leaves no less room for another. */
START_TEST(so_many_of_each_class)
{
    static const int far[] = { 0, 0, 0, 0 };
    const detection_rules rules = { .score = 0.001, .iou = 0.7, .most = 5, .every_class = true };
    detection *found;
    int n, of[NC] = { 0 };

    for (int i = 0; i < 12; i++)
        see(0, i, 0, 5 - 0.1f * (float)i, far);
    for (int i = 20; i < 23; i++)
        see(0, i, 2, -2, far);
    check_ok(detection_find(arena, &maps, &rules, &found, &n));
    for (int i = 0; i < n; i++)
        of[found[i].cls]++;
    ck_assert_int_eq(of[0], 5);
    ck_assert_int_eq(of[1], 0);
    ck_assert_int_eq(of[2], 3);
    ck_assert_float_eq_tol(found[4].score, 1 / (1 + expf(-4.6f)), 1e-6f);
    ck_assert_int_eq(detection_rules_scored.most, 100);
}
END_TEST

/* ---- masks ---- */

static double sigmoid_at(const detection *d, int x, int y)
{
    double z = 0;

    for (int k = 0; k < 32; k++)
        z += (double)d->coefficient[k] * (double)proto[(k * SIDE + y) * SIDE + x];
    return 1 / (1 + exp(-z));
}

static double clamped(double v)
{
    return fmin(fmax(v, 0), SIDE - 1);
}

static double mixed(const detection *d, double x, double y)
{
    const int x0 = (int)clamped(x), y0 = (int)clamped(y), x1 = (int)clamped(x0 + 1), y1 = (int)clamped(y0 + 1);
    const double u = clamped(x) - x0, v = clamped(y) - y0;

    return (1 - v) * ((1 - u) * sigmoid_at(d, x0, y0) + u * sigmoid_at(d, x1, y0))
           + v * ((1 - u) * sigmoid_at(d, x0, y1) + u * sigmoid_at(d, x1, y1));
}

START_TEST(masks)
{
    static const float places[][4] = { { 3, 14, 40, 49.5f }, { -5, 10, 70, 70 }, { 30, 30, 30.5f, 60 } };
    enum { WIDTH = 90, HEIGHT = 50 };
    const letterbox l = letterbox_of(WIDTH, HEIGHT, SIZE);
    detection d[3] = { { 0 } };
    detection_pixels p[3];

    for (int i = 0; i < 3; i++) {
        memcpy(d[i].box, places[i], sizeof(places[i]));
        for (int k = 0; k < 32; k++)
            d[i].coefficient[k] = mask[0][k * CELLS + i];
    }
    check_ok(detection_pixels_of(arena, &maps, d, 3, &l, WIDTH, HEIGHT, p));
    for (int i = 0; i < 3; i++) {
        float b[4];

        letterbox_back(&l, WIDTH, HEIGHT, d[i].box, b);
        for (int at = 0; at < WIDTH * HEIGHT; at++) {
            const int x = at % WIDTH, y = at / WIDTH;
            const bool in = x >= p[i].x0 && x < p[i].x1 && y >= p[i].y0 && y < p[i].y1 && p[i].pixel;
            const double u = ((x + 0.5) * l.scale + l.left) / 4 - 0.5, v = ((y + 0.5) * l.scale + l.top) / 4 - 0.5;
            const double value = mixed(&d[i], u, v);

            if (fabs(value - 0.5) < 1e-4)
                continue;
            ck_assert_int_eq(in && p[i].pixel[(y - p[i].y0) * (p[i].x1 - p[i].x0) + x - p[i].x0],
                             value > 0.5 && x + 0.5f >= b[0] && x + 0.5f < b[2] && y + 0.5f >= b[1] && y + 0.5f < b[3]);
        }
    }
}
END_TEST

START_TEST(letterboxes)
{
    const letterbox l = letterbox_of(100, 50, 64);
    const float inside[] = { 0, 16, 64, 48 }, outside[] = { -9, 0, 99, 99 };
    lt_image img;
    float b[4], *out = lt_arena_array(arena, 3 * 64 * 64, sizeof(*out));

    ck_assert_double_eq_tol(l.scale, 0.64, 1e-12);
    ck_assert_double_eq(l.top, 16);
    letterbox_back(&l, 100, 50, inside, b);
    ck_assert_float_eq_tol(b[2], 100, 1e-4f);
    ck_assert_float_eq_tol(b[3], 50, 1e-4f);
    letterbox_back(&l, 100, 50, outside, b);
    ck_assert_float_eq(b[0], 0);
    ck_assert_float_eq(b[3], 50);
    check_ok(lt_image_init(arena, 100, 50, 3, 8, &img));
    memset(img.data, 51, 100 * 50 * 3);
    letterbox_picture(&l, &img, 64, out);
    ck_assert_float_eq_tol(out[15 * 64 + 30], LETTERBOX_GREY, 1e-6f);
    ck_assert_float_eq_tol(out[2 * 4096 + 30 * 64 + 30], 0.2f, 1e-6f);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, boxes);
    tcase_add_test(tc, the_surest_alone);
    tcase_add_test(tc, every_class_of_a_cell);
    tcase_add_test(tc, so_many_of_each_class);
    tcase_add_test(tc, masks);
    tcase_add_test(tc, letterboxes);
}

int main(void)
{
    return run_suite("detection", add_tests);
}
