/* SPDX-License-Identifier: Apache-2.0 */
/* Object pose errors on a five-point model; the numbers were computed with the official
 * formulas. */
#include "eval/scorers/object_score.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/rotation.h"
#include "tests/eval/lcg.h"
#include "tests/eval/object_vectors.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

#define TOL 1e-6

static const double model[15] = { .05, .03, 0, -.05, .03, 0, -.05, -.03, 0, .05, -.03, 0, 0, 0, .08 };
static const lt_camera camera = { 600, 600, 320, 240 };
static const lt_pose truth = { { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, { 0, 0, .6 } };
static const lt_pose half_turn = { { -1, 0, 0, 0, -1, 0, 0, 0, 1 }, { 0, 0, 0 } };

static lt_pose turned(double degrees, double x, double y, double z)
{
    const double aa[3] = { 0, 0, degrees * M_PI / 180 };
    lt_pose p = { .t = { x, y, z } };

    lt_rot_from_axis_angle(aa, p.R);
    return p;
}

static double adds(eval_adds_direction direction, const lt_pose *e)
{
    double d;

    ck_assert_int_eq(eval_adds(direction, 5, model, e, &truth, &d), LT_OK);
    return d;
}

START_TEST(half_turn_and_a_shift)
{
    const lt_pose e = turned(180, .01, 0, .6);

    ck_assert_double_eq_tol(eval_add(5, model, &e, &truth), .095386, TOL);
    ck_assert_double_eq_tol(adds(EVAL_FROM_TRUE, &e), .01, TOL);
    ck_assert_double_eq_tol(eval_mssd(5, model, &e, &truth, 0, NULL), .1253, TOL);
    ck_assert_double_eq_tol(eval_mssd(5, model, &e, &truth, 1, &half_turn), .01, TOL);
    ck_assert_double_eq_tol(eval_mspd(5, model, &e, &truth, 0, NULL, &camera), 125.299641, TOL);
    ck_assert_double_eq_tol(eval_mspd(5, model, &e, &truth, 1, &half_turn, &camera), 10, TOL);
    ck_assert_double_eq_tol(eval_rotation_error_deg(&e, &truth), 180, TOL);
    ck_assert_double_eq_tol(eval_reprojection_px(5, model, &e, &truth, &camera, 0), 95.151178, TOL);
    ck_assert_double_eq_tol(eval_oce(&e, &truth), .01, TOL);
    ck_assert_double_eq_tol(eval_mce(5, model, &e, &truth), .01, TOL);
}
END_TEST

START_TEST(small_turn_and_a_shift)
{
    const lt_pose e = turned(10, .002, -.001, .604);
    const double add = eval_add(5, model, &e, &truth);

    ck_assert_double_eq_tol(add, .009775, TOL);
    ck_assert_double_eq_tol(adds(EVAL_FROM_TRUE, &e), .009775, TOL);
    ck_assert_double_eq_tol(eval_rotation_error_deg(&e, &truth), 10, TOL);
    ck_assert_double_eq_tol(eval_reprojection_px(5, model, &e, &truth, &camera, 0), 8.616860, TOL);
    ck_assert_double_eq_tol(eval_reprojection_px(5, model, &e, &truth, &camera, 1e-5), 8.616725, TOL);
    ck_assert_double_eq_tol(eval_oce(&e, &truth), .004583, TOL);
    ck_assert_double_eq_tol(eval_mce(5, model, &e, &truth), .010348, TOL);
    ck_assert(add <= .1 * eval_diameter(EVAL_BBOX_DIAG, 5, model));
    ck_assert(add <= .1 * eval_diameter(EVAL_MAX_DIST, 5, model));
}
END_TEST

/* The two directions of ADD-S differ: all true points are near one estimated one, not the
 * reverse. */
START_TEST(directions)
{
    static const double two[6] = { 0, 0, 0, .1, 0, 0 };
    const lt_pose shifted = { { 1, 0, 0, 0, 1, 0, 0, 0, 1 }, { .1, 0, .6 } };
    const lt_pose flat = { { 0 }, { 0, 0, .6 } };         /* both points on the first true one */
    double from_true, from_estimate;

    ck_assert_int_eq(eval_adds(EVAL_FROM_TRUE, 2, two, &flat, &truth, &from_true), LT_OK);
    ck_assert_int_eq(eval_adds(EVAL_FROM_ESTIMATE, 2, two, &flat, &truth, &from_estimate), LT_OK);
    ck_assert_double_eq_tol(from_true, .05, TOL);
    ck_assert_double_eq_tol(from_estimate, 0, TOL);
    ck_assert_int_eq(eval_adds(EVAL_FROM_TRUE, 2, two, &shifted, &truth, &from_true), LT_OK);
    ck_assert_double_eq_tol(from_true, .05, TOL);
}
END_TEST

/* Cayley's rotation of v: rational, so that the script has the same one. */
static void cayley(const double v[3], double R[9])
{
    const double vv = lt_vec3_dot(v, v);
    const double S[9] = { 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0 };

    for (int i = 0; i < 9; i++)
        R[i] = ((i % 4 == 0) * (1 - vv) + 2 * v[i / 3] * v[i % 3] + 2 * S[i]) / (1 + vv);
}

static void draw3(uint32_t *state, double scale, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = lcg(state) * scale;
}

START_TEST(random_poses)
{
    static const double size[3] = { .05, .08, .03 };
    static const lt_camera wide = { 600, 610, 320, 240 };
    uint32_t state = 100 + (uint32_t)_i;
    double x[150], v[3], turn[9], found[11];
    lt_pose e, g;

    for (int i = 0; i < 150; i++)
        x[i] = lcg(&state) * size[i % 3];
    draw3(&state, 1, v);
    cayley(v, g.R);
    draw3(&state, .1, g.t);
    g.t[2] += .7;
    draw3(&state, .2, v);
    cayley(v, turn);
    lt_mat3_mul(turn, g.R, e.R);
    draw3(&state, .02, e.t);
    for (int k = 0; k < 3; k++)
        e.t[k] += g.t[k];

    found[0] = eval_add(50, x, &e, &g);
    ck_assert_int_eq(eval_adds(EVAL_FROM_TRUE, 50, x, &e, &g, &found[1]), LT_OK);
    ck_assert_int_eq(eval_adds(EVAL_FROM_ESTIMATE, 50, x, &e, &g, &found[2]), LT_OK);
    found[3] = eval_mssd(50, x, &e, &g, 1, &half_turn);
    found[4] = eval_mspd(50, x, &e, &g, 1, &half_turn, &wide);
    found[5] = eval_rotation_error_deg(&e, &g);
    found[6] = eval_oce(&e, &g);
    found[7] = eval_reprojection_px(50, x, &e, &g, &wide, 1e-5);
    found[8] = eval_mce(50, x, &e, &g);
    found[9] = eval_diameter(EVAL_BBOX_DIAG, 50, x);
    found[10] = eval_diameter(EVAL_MAX_DIST, 50, x);
    for (int k = 0; k < 11; k++)
        ck_assert_double_eq_tol(found[k], object_wanted[_i][k], 1e-9 * (1 + object_wanted[_i][k]));
}
END_TEST

START_TEST(diameters)
{
    ck_assert_double_eq_tol(eval_diameter(EVAL_BBOX_DIAG, 5, model), .141421, TOL);
    ck_assert_double_eq_tol(eval_diameter(EVAL_MAX_DIST, 5, model), .116619, TOL);
    ck_assert_double_eq(eval_diameter(EVAL_BBOX_DIAG, 0, NULL), 0);
    ck_assert_double_eq(eval_diameter(EVAL_MAX_DIST, 0, NULL), 0);
    ck_assert_str_eq(eval_diameter_name(EVAL_BBOX_DIAG), "bbox_diag");
    ck_assert_str_eq(eval_diameter_name(EVAL_MAX_DIST), "max_dist");
}
END_TEST

START_TEST(symmetries)
{
    int count[4] = { 0 };

    for (int list = EVAL_SYM_NONE; list <= EVAL_SYM_BOP; list++) {
        for (int id = -1; id <= 40; id++)
            count[list] += eval_is_symmetric((eval_symmetry_list)list, id);
    }
    ck_assert_int_eq(count[EVAL_SYM_NONE], 0);
    ck_assert_int_eq(count[EVAL_SYM_HFL], 4);
    ck_assert_int_eq(count[EVAL_SYM_POSECNN], 5);
    ck_assert_int_eq(count[EVAL_SYM_BOP], 8);
    ck_assert(eval_is_symmetric(EVAL_SYM_HFL, 21) && !eval_is_symmetric(EVAL_SYM_HFL, 19));
    ck_assert_str_eq(eval_symmetry_name(EVAL_SYM_POSECNN), "posecnn");
}
END_TEST

START_TEST(equal_poses)
{
    ck_assert_double_eq(eval_add(5, model, &truth, &truth), 0);
    ck_assert_double_eq(adds(EVAL_FROM_TRUE, &truth), 0);
    ck_assert_double_eq(adds(EVAL_FROM_ESTIMATE, &truth), 0);
    ck_assert_double_eq(eval_mssd(5, model, &truth, &truth, 1, &half_turn), 0);
    ck_assert_double_eq(eval_mce(5, model, &truth, &truth), 0);
    ck_assert_double_eq(eval_rotation_error_deg(&truth, &truth), 0);
}
END_TEST

START_TEST(not_numbers_are_failures)
{
    lt_pose e = truth;
    double d;

    (_i % 2 ? e.R : e.t)[1] = _i < 2 ? NAN : INFINITY;
    ck_assert(!lt_pose_finite(&e) && lt_pose_finite(&truth));
    ck_assert(isinf(eval_add(5, model, &e, &truth)));
    ck_assert(isinf(adds(EVAL_FROM_TRUE, &e)) && isinf(adds(EVAL_FROM_ESTIMATE, &e)));
    ck_assert(isinf(eval_mssd(5, model, &e, &truth, 1, &half_turn)));
    ck_assert(isinf(eval_mspd(5, model, &e, &truth, 0, NULL, &camera)));
    ck_assert(isinf(eval_reprojection_px(5, model, &e, &truth, &camera, 1e-5)));
    ck_assert(isinf(eval_mce(5, model, &e, &truth)));
    ck_assert(isinf(_i % 2 ? eval_rotation_error_deg(&e, &truth) : eval_oce(&e, &truth)));
    ck_assert(isnan(eval_add(0, NULL, &truth, &truth)));
    lt_alloc_fail_at(1);
    ck_assert_int_eq(eval_adds(EVAL_FROM_TRUE, 5, model, &truth, &truth, &d), LT_ENOMEM);
}
END_TEST

/* Many samples at once give what one at a time gives, on any number of threads. */
START_TEST(all_at_once)
{
    enum { N = 7 };
    static const eval_object objects[2] = { { 5, model, false }, { 5, model, true } };
    const int32_t which[N] = { 0, 1, -1, 0, 1, 1, 0 };
    lt_pose e[N], g[N];
    lt_camera cameras[N];
    eval_object_errors one[N], many[N];

    for (int i = 0; i < N; i++) {
        g[i] = truth;
        e[i] = turned(180 * (i % 2) + i, .01 * i, 0, .6);
        cameras[i] = camera;
    }
    lt_set_threads(1);
    ck_assert_int_eq(eval_object_measure(objects, N, which, e, g, cameras, one), LT_OK);
    lt_set_threads(3);
    ck_assert_int_eq(eval_object_measure(objects, N, which, e, g, cameras, many), LT_OK);
    ck_assert_int_eq(memcmp(one, many, sizeof(one)), 0);
    for (int i = 0; i < N; i++) {
        if (i == 2) {
            ck_assert(isnan(one[i].add_or_adds) && isnan(one[i].mce));
            continue;
        }
        ck_assert_double_eq(one[i].add, eval_add(5, model, &e[i], &truth));
        ck_assert_double_eq(one[i].adds_true, adds(EVAL_FROM_TRUE, &e[i]));
        ck_assert_double_eq(one[i].add_or_adds, which[i] ? adds(EVAL_FROM_ESTIMATE, &e[i]) : one[i].add);
        ck_assert_double_eq(one[i].reprojection_px,
                            eval_reprojection_px(5, model, &e[i], &truth, &camera, 1e-5));
        ck_assert_double_eq(one[i].rotation_deg, eval_rotation_error_deg(&e[i], &truth));
        ck_assert_double_eq(one[i].mce, eval_mce(5, model, &e[i], &truth));
        ck_assert_double_eq(one[i].oce, eval_oce(&e[i], &truth));
    }
    lt_alloc_fail_at(2);
    ck_assert_int_eq(eval_object_measure(objects, N, which, e, g, cameras, many), LT_ENOMEM);
    ck_assert_int_eq(eval_object_measure(objects, 0, NULL, NULL, NULL, NULL, NULL), LT_OK);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_test(t, half_turn_and_a_shift);
    tcase_add_test(t, small_turn_and_a_shift);
    tcase_add_test(t, directions);
    tcase_add_loop_test(t, random_poses, 0, 5);
    tcase_add_test(t, diameters);
    tcase_add_test(t, symmetries);
    tcase_add_test(t, equal_poses);
    tcase_add_loop_test(t, not_numbers_are_failures, 0, 4);
    tcase_add_test(t, all_at_once);
}

int main(void)
{
    return run_suite("object_pose", add_tests);
}
