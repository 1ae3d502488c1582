/* SPDX-License-Identifier: Apache-2.0 */
/* What is cut out of a picture for a network to look at. */
#include "tests/suite.h"
#include "vision/track/look.h"

#include <math.h>

enum { WIDTH = 40, HEIGHT = 30, H = 8, W = 4 };

static uint8_t pixel[3 * WIDTH * HEIGHT];
static lt_image rgb = { .data = pixel, .width = WIDTH, .height = HEIGHT, .channels = 3 };
static float out[3 * H * W];

/* Red grows to the right, green downwards */
static void setup(void)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        pixel[3 * i] = (uint8_t)(5 * (i % WIDTH));
        pixel[3 * i + 1] = (uint8_t)(7 * (i / WIDTH));
        pixel[3 * i + 2] = 255;
    }
}

static double at(int c, int y, int x)
{
    return 255 * (double)out[(c * H + y) * W + x];
}

/* The middle of an output pixel is that of the part of the box that it stands for. */
START_TEST(stretched)
{
    ck_assert(look_cut(&rgb, (float[]){ 10, 5, 18, 21 }, false, W, H, out));
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            ck_assert_double_eq_tol(at(0, y, x), 5 * (10 + 2 * (x + 0.5) - 0.5), 1e-3);
            ck_assert_double_eq_tol(at(1, y, x), 7 * (5 + 2 * (y + 0.5) - 0.5), 1e-3);
            ck_assert_double_eq(at(2, y, x), 255);
        }
}
END_TEST

/* A person's box of 16 in height is 8 wide about its middle, whatever it was. */
START_TEST(person)
{
    float as_person[3 * H * W];

    ck_assert(look_cut(&rgb, (float[]){ 4, 5, 24, 21 }, true, W, H, as_person));
    ck_assert(look_cut(&rgb, (float[]){ 10, 5, 18, 21 }, false, W, H, out));
    ck_assert_mem_eq(as_person, out, sizeof(out));
}
END_TEST

/* What reaches outside is cut off there; what has nothing inside is nothing. */
START_TEST(borders)
{
    float cut[3 * H * W];

    ck_assert(look_cut(&rgb, (float[]){ -10, -10, 4, 8 }, false, W, H, cut));
    ck_assert(look_cut(&rgb, (float[]){ 0, 0, 4, 8 }, false, W, H, out));
    ck_assert_mem_eq(cut, out, sizeof(out));
    ck_assert(!look_cut(&rgb, (float[]){ 40, 0, 50, 8 }, false, W, H, out));
    ck_assert(!look_cut(&rgb, (float[]){ 5, 5, 5, 8 }, false, W, H, out));
    ck_assert(!look_cut(&rgb, (float[]){ 5, 9, 8, 8 }, true, W, H, out));
    ck_assert(!look_cut(&rgb, (float[]){ NAN, 0, 8, 8 }, false, W, H, out));
    ck_assert(!look_cut(&rgb, (float[]){ 0, 0, INFINITY, 8 }, false, W, H, out));
    ck_assert(!look_cut(&rgb, (float[]){ 0, NAN, 8, 8 }, false, W, H, out));
    ck_assert_mem_eq(cut, out, sizeof(out));
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, NULL);
    tcase_add_test(tc, stretched);
    tcase_add_test(tc, person);
    tcase_add_test(tc, borders);
}

int main(void)
{
    return run_suite("look", add_tests);
}
