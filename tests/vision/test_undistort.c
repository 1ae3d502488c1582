/* SPDX-License-Identifier: Apache-2.0 */
/* Lenses and pictures through them, as OpenCV has them. */
#include "tests/suite.h"
#include "tests/vision/lens_vectors.h"
#include "vision/undistort.h"

#include <math.h>
#include <stdlib.h>

enum { WIDTH = 40, HEIGHT = 30, POINTS = LT_COUNT(lens_points) / 2 };

/* scripts/vectors/lens.py has them too */
static const struct { double c[8]; int n; const double *seen; const uint8_t *undistorted; } lenses[] = {
    { { -0.28, 0.07, 0.001, -0.002 }, 4, lens_seen_0, lens_undistorted_0 },
    { { 0.12, -0.05, -0.003, 0.002, 0.01 }, 5, lens_seen_1, lens_undistorted_1 },
    { { 0.4, -0.1, 0.001, 0.0005, 0.02, 0.5, -0.05, 0.01 }, 8, lens_seen_2, lens_undistorted_2 },
};

static undistortion camera_with(int i)
{
    undistortion u = { .camera = { 36, 34, 21, 13.5 }, .width = WIDTH, .height = HEIGHT };

    check_ok(lt_lens_from_opencv(lenses[i].c, lenses[i].n, &u.lens));
    return u;
}

START_TEST(points)
{
    const lt_lens lens = camera_with(_i).lens;

    for (int k = 0; k < POINTS; k++) {
        double x[2], back[2];

        lt_lens_distort(&lens, lens_points + 2 * k, x);
        ck_assert(lt_lens_undistort(&lens, x, back));
        for (int d = 0; d < 2; d++) {
            ck_assert_double_eq_tol(x[d], lenses[_i].seen[2 * k + d], 1e-9);
            ck_assert_double_eq_tol(back[d], lens_points[2 * k + d], 1e-8);
        }
    }
}
END_TEST

/* OpenCV rounds places to a 32nd of a pixel, and takes the edge's neighbours as black as we do. */
START_TEST(pictures)
{
    const undistortion u = camera_with(_i);
    uint8_t out[3 * WIDTH * HEIGHT];

    undistort_rgb(&u, lens_picture, out);
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
        ck_assert_msg(abs(out[i] - lenses[_i].undistorted[i]) <= 5, "%d: %d, want %d", i, out[i],
                      lenses[_i].undistorted[i]);
}
END_TEST

/* Depth is not mixed, and unknown where the lens saw nothing; a box holds what was in it. */
START_TEST(depth_and_boxes)
{
    const undistortion u = camera_with(0);
    const crop_box box = { 4, 3, 20, 25 };
    const crop_box out = undistort_box(&u, box);
    float depth[WIDTH * HEIGHT], flat[WIDTH * HEIGHT];
    double p[2] = { (4 - 21.0) / 36, (3 - 13.5) / 34 };

    for (int i = 0; i < WIDTH * HEIGHT; i++)
        depth[i] = i % WIDTH < 20 ? 1 : 2;
    undistort_depth(&u, depth, flat);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        ck_assert(flat[i] == 0 || flat[i] == 1 || flat[i] == 2);
    ck_assert_float_eq(flat[15 * WIDTH + 10], 1);
    ck_assert_float_eq(flat[15 * WIDTH + 30], 2);
    ck_assert(lt_lens_undistort(&u.lens, p, p));
    ck_assert_double_eq_tol((double)out.x0, p[0] * 36 + 21, 1.5);
    ck_assert(out.x0 <= (float)(p[0] * 36 + 21) && out.y0 <= (float)(p[1] * 34 + 13.5));
    ck_assert(out.x0 < box.x0 && out.x1 < box.x1 + 1 && out.y1 > box.y1);      /* a barrel is pulled out */
}
END_TEST

/* No lens, too many numbers, and numbers that are none of a lens's */
START_TEST(wrong)
{
    const double many[14] = { 0.1, 0, 0, 0, 0, 0, 0, 0, 0.01 }, none[5] = { 0 }, bad[4] = { 0.1, NAN };
    const lt_lens shrinking = { .k = { -0.5 } };
    double c[LT_LENS_COEFFICIENTS];
    lt_lens lens;

    check_ok(lt_lens_from_opencv(none, 5, &lens));
    ck_assert(lt_lens_is_none(&lens));
    check_error(lt_lens_from_opencv(many, 3, &lens), LT_EINVAL, "3 coefficients of a lens, want 4, 5 or 8");
    check_error(lt_lens_from_opencv(many, 14, &lens), LT_EINVAL, "coefficient 9 of a lens is 0.01, want 0");
    check_error(lt_lens_from_opencv(bad, 4, &lens), LT_EINVAL, "coefficient 2 of a lens is not finite");
    check_ok(lt_lens_from_opencv(lenses[2].c, 8, &lens));
    lt_lens_to_opencv(&lens, c);
    ck_assert_mem_eq(c, lenses[2].c, sizeof(c));
    ck_assert_double_eq_tol(lt_lens_fold(&shrinking, 2), sqrt(1 / 1.5), 0.01);
    ck_assert(isinf(lt_lens_fold(&lens, 0.5)));
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_loop_test(t, points, 0, LT_COUNT(lenses));
    tcase_add_loop_test(t, pictures, 0, LT_COUNT(lenses));
    tcase_add_test(t, depth_and_boxes);
    tcase_add_test(t, wrong);
}

int main(void)
{
    return run_suite("undistort", add_tests);
}
