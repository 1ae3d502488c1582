/* SPDX-License-Identifier: Apache-2.0 */
/* The translation that puts points where they are seen. */
#include "libtensor/geometry/translation.h"
#include "tests/suite.h"

#include <math.h>

enum { N = 6 };

static const lt_camera camera = { .fx = 620, .fy = 600, .cx = 310.5, .cy = 244 };
static const double shape[3 * N] = {
    0, 0, 0,  .03, -.02, .01,  .09, .01, -.02,  -.04, .06, .03,  .02, .08, -.05,  -.07, -.03, .02,
};
static const double place[3] = { .08, -.05, .55 };

static void see(const double *X, const double t[3], double *uv)
{
    for (int i = 0; i < N; i++) {
        const double p[3] = { X[3 * i] + t[0], X[3 * i + 1] + t[1], X[3 * i + 2] + t[2] };

        lt_camera_project(&camera, p, uv + 2 * i);
    }
}

static void expect(const double t[3], double tolerance)
{
    for (int d = 0; d < 3; d++)
        ck_assert_double_eq_tol(t[d], place[d], tolerance);
}

START_TEST(exact)
{
    double uv[2 * N], t[3];

    see(shape, place, uv);
    ck_assert_int_eq(lt_hand_translation(&camera, N, shape, uv, NULL, t), LT_OK);
    expect(t, 1e-12);
    ck_assert_int_eq(lt_hand_translation(&camera, 2, shape, uv, NULL, t), LT_OK);
    expect(t, 1e-11);
}
END_TEST

/* The least squares' own condition: the gradient of the sum of squares is zero. */
START_TEST(stationary)
{
    const double weight[N] = { 1, .3, .9, .2, .6, .5 };
    double uv[2 * N], t[3], g[3] = { 0 };

    see(shape, place, uv);
    for (int i = 0; i < 2 * N; i++)
        uv[i] += 3 * sin(7 * i);
    ck_assert_int_eq(lt_hand_translation(&camera, N, shape, uv, weight, t), LT_OK);
    for (int i = 0; i < N; i++) {
        const double du = uv[2 * i] - camera.cx, dv = uv[2 * i + 1] - camera.cy, z = shape[3 * i + 2] + t[2];
        const double ex = camera.fx * (shape[3 * i] + t[0]) - du * z;
        const double ey = camera.fy * (shape[3 * i + 1] + t[1]) - dv * z;

        g[0] += weight[i] * camera.fx * ex;
        g[1] += weight[i] * camera.fy * ey;
        g[2] -= weight[i] * (du * ex + dv * ey);
    }
    for (int d = 0; d < 3; d++)
        ck_assert_double_eq_tol(g[d], 0, 1e-7);
    expect(t, .05);
}
END_TEST

START_TEST(weights)
{
    const double weight[N] = { 1, 1, 1, 1, 1, 0 }, none[N] = { 0 };
    double uv[2 * N], t[3] = { 9, 9, 9 };

    see(shape, place, uv);
    uv[2 * N - 1] += 500;                       /* a wrong joint that nobody believes */
    ck_assert_int_eq(lt_hand_translation(&camera, N, shape, uv, none, t), LT_ENUMERIC);
    ck_assert_double_eq(t[0], 9);
    ck_assert_int_eq(lt_hand_translation(&camera, N, shape, uv, weight, t), LT_OK);
    expect(t, 1e-12);
}
END_TEST

/* The depth given, what is across follows; from one point, and stationary where points disagree. */
START_TEST(known_depth)
{
    const double weight[N] = { 1, .3, .9, .2, .6, .5 }, far = place[2] + .02;
    double uv[2 * N], t[3], g[2] = { 0 };

    see(shape, place, uv);
    ck_assert_int_eq(lt_hand_translation_at(&camera, 1, shape + 3, uv + 2, NULL, place[2], t), LT_OK);
    expect(t, 1e-12);
    ck_assert_int_eq(lt_hand_translation_at(&camera, N, shape, uv, weight, far, t), LT_OK);
    ck_assert_double_eq(t[2], far);
    for (int i = 0; i < N; i++) {
        const double z = shape[3 * i + 2] + t[2];

        g[0] += weight[i] * (camera.fx * (shape[3 * i] + t[0]) - (uv[2 * i] - camera.cx) * z);
        g[1] += weight[i] * (camera.fy * (shape[3 * i + 1] + t[1]) - (uv[2 * i + 1] - camera.cy) * z);
    }
    ck_assert_double_eq_tol(g[0], 0, 1e-10);
    ck_assert_double_eq_tol(g[1], 0, 1e-10);
    t[0] = 9;
    ck_assert_int_eq(lt_hand_translation_at(&camera, N, shape, uv, NULL, 0, t), LT_ENUMERIC);
    ck_assert_int_eq(lt_hand_translation_at(&camera, N, shape, uv, NULL, NAN, t), LT_ENUMERIC);
    ck_assert_int_eq(lt_hand_translation_at(&camera, 0, shape, uv, NULL, 1, t), LT_EINVAL);
    ck_assert_double_eq(t[0], 9);
}
END_TEST

START_TEST(refused)
{
    const lt_camera blind = { .fx = 0, .fy = 600 };
    const double negative[N] = { 1, 1, -1, 1, 1, 1 };
    double uv[2 * N], same[2 * N], t[3] = { 9, 9, 9 };

    see(shape, place, uv);
    for (int i = 0; i < 2 * N; i++)
        same[i] = 100;
    ck_assert_int_eq(lt_hand_translation(&camera, N, shape, same, NULL, t), LT_ENUMERIC);
    for (int i = 0; i < 2 * N; i++)             /* upside down and mirrored: seen from behind */
        same[i] = -uv[i];
    ck_assert_int_eq(lt_hand_translation(&camera, N, shape, same, NULL, t), LT_ENUMERIC);
    ck_assert_int_eq(lt_hand_translation(&camera, 1, shape, uv, NULL, t), LT_EINVAL);
    ck_assert_int_eq(lt_hand_translation(&blind, N, shape, uv, NULL, t), LT_EINVAL);
    ck_assert_int_eq(lt_hand_translation(&camera, N, shape, uv, negative, t), LT_EINVAL);
    uv[3] = NAN;
    ck_assert_int_eq(lt_hand_translation(&camera, N, shape, uv, NULL, t), LT_EINVAL);
    ck_assert_double_eq(t[2], 9);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_test(c, exact);
    tcase_add_test(c, stationary);
    tcase_add_test(c, weights);
    tcase_add_test(c, known_depth);
    tcase_add_test(c, refused);
}

int main(void)
{
    return run_suite("translation", add_tests);
}
