/* SPDX-License-Identifier: Apache-2.0 */
/* Point-set errors against the official formulas; the numbers were computed with NumPy and
 * SciPy. */
#include "eval/metrics/metrics.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/mat3.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

#define TOL 1e-6

static const double G[15] = { 0, 0, 0, .1, 0, 0, 0, .1, 0, 0, 0, .1, .05, .05, .02 };

/* 1.5 Rz(30 degrees) G + (0.3, -0.2, 0.5), the last point 10 mm off in x */
static void predict(double p[15])
{
    const double c = 1.5 * cos(M_PI / 6), s = 1.5 * sin(M_PI / 6);

    for (int i = 0; i < 5; i++) {
        const double *g = G + 3 * i;

        p[3 * i] = c * g[0] - s * g[1] + .3 + (i == 4 ? .01 : 0);
        p[3 * i + 1] = s * g[0] + c * g[1] - .2;
        p[3 * i + 2] = 1.5 * g[2] + .5;
    }
}

static void expect_points(const double *found, const double *wanted)
{
    for (int i = 0; i < 15; i++)
        ck_assert_double_eq_tol(found[i], wanted[i], TOL);
}

START_TEST(plain_and_root_relative)
{
    double p[15], d[5];

    predict(p);
    ck_assert_double_eq_tol(p[12], .3374519, TOL);
    ck_assert_double_eq_tol(eval_mpjpe(5, p, G), .612766, TOL);
    eval_distances(5, p, G, d);
    ck_assert_double_eq_tol(eval_mean(5, d), .612766, TOL);
    eval_align_root(5, p, G, 0, p);
    ck_assert_double_eq_tol(eval_mpjpe(5, p, G), .053267, TOL);
}
END_TEST

START_TEST(procrustes_of_both_kinds)
{
    static const double aligned[15] = {
        -.000697, .000388, .000106, .098944, .001541, .000136, -.001850, .100029, .000001,
        -.000729, .000492, .099754, .054332, .047551, .020003,
    };
    static const double error[5] = { .000805, .001873, .001850, .000913, .004976 };
    double p[15], d[5];

    predict(p);
    eval_align_procrustes(_i ? EVAL_RIGID : EVAL_REFLECT, 5, p, G, p);
    expect_points(p, aligned);
    eval_distances(5, p, G, d);
    for (int i = 0; i < 5; i++)
        ck_assert_double_eq_tol(d[i], error[i], TOL);
    ck_assert_double_eq_tol(eval_mean(5, d), .002083, TOL);
}
END_TEST

START_TEST(mirror_images)
{
    double p[15], out[15];

    for (int i = 0; i < 15; i++)
        p[i] = i % 3 ? G[i] : -G[i];
    eval_align_procrustes(EVAL_REFLECT, 5, p, G, out);
    ck_assert_double_eq_tol(eval_mpjpe(5, out, G), 0, TOL);
    eval_align_procrustes(EVAL_RIGID, 5, p, G, out);
    ck_assert_double_eq_tol(eval_mpjpe(5, out, G), .039883, TOL);
}
END_TEST

START_TEST(one_point_predictions)
{
    const double zero[15] = { 0 };
    double out[15];

    eval_align_procrustes(EVAL_REFLECT, 5, zero, G, out);
    ck_assert_double_eq_tol(eval_mpjpe(5, out, G), .064810, TOL);
    for (int i = 0; i < 15; i++)
        ck_assert_double_eq_tol(out[i], i % 3 == 2 ? .024 : .03, TOL);
    eval_align_scale(5, zero, G, 0, 4, out);
    ck_assert_double_eq_tol(eval_mpjpe(5, out, G), .074697, TOL);
}
END_TEST

START_TEST(scale_and_translation)
{
    static const double aligned[15] = {
        0, 0, 0, .084378, .048716, 0, -.048716, .084378, 0, 0, 0, .097432, .024327, .066547, .019486,
    };
    double p[15];

    predict(p);
    eval_align_scale(5, p, G, 0, 4, p);
    expect_points(p, aligned);
    ck_assert_double_eq_tol(eval_mpjpe(5, p, G), .027087, TOL);
}
END_TEST

/* A random similarity of a random cloud is undone by either alignment. */
START_TEST(similarities_are_undone)
{
    lt_rng rng = lt_rng_make(7, (uint64_t)_i);
    double g[3 * 40], p[3 * 40];
    const double angle = lt_rng_range(&rng, -3, 3), scale = lt_rng_range(&rng, .1, 5);
    const double c = scale * cos(angle), s = scale * sin(angle);

    for (int i = 0; i < 40; i++) {
        for (int k = 0; k < 3; k++)
            g[3 * i + k] = lt_rng_normal(&rng);
        p[3 * i] = c * g[3 * i] - s * g[3 * i + 2] + 1;
        p[3 * i + 1] = scale * g[3 * i + 1] - 2;
        p[3 * i + 2] = s * g[3 * i] + c * g[3 * i + 2] + 3;
    }
    eval_align_procrustes(_i % 2 ? EVAL_RIGID : EVAL_REFLECT, 40, p, g, p);
    ck_assert_double_le(eval_mpjpe(40, p, g), 1e-6);
}
END_TEST

START_TEST(f_scores)
{
    static const double g[12] = { 0, 0, 0, .010, 0, 0, .020, 0, 0, .030, 0, 0 };
    static const double p[9] = { .003, 0, 0, .016, 0, 0, .090, 0, 0 };
    double d_p[3], d_g[4];
    eval_f s;

    ck_assert_int_eq(eval_nearest(3, p, 4, g, d_p, d_g), LT_OK);
    s = eval_f_score(3, d_p, 4, d_g, .005);
    ck_assert_double_eq_tol(s.f, .571429, TOL);
    ck_assert_double_eq_tol(s.recall, .5, TOL);
    ck_assert_double_eq_tol(s.precision, .666667, TOL);
    s = eval_f_score(3, d_p, 4, d_g, .015);
    ck_assert_double_eq_tol(s.f, .8, TOL);
    ck_assert_double_eq_tol(s.recall, 1, TOL);
    ck_assert_double_eq_tol(s.precision, .666667, TOL);
}
END_TEST

START_TEST(chamfer)
{
    static const double p[9] = { 0, 0, 0, .01, 0, 0, 0, .02, 0 };
    static const double g[12] = { .003, 0, 0, .012, 0, 0, 0, .028, 0, .05, 0, 0 };
    static const double far_g[4] = { .003, .002, .008, .040 };
    double d_p[3], d_g[4];

    ck_assert_int_eq(eval_nearest(3, p, 4, g, d_p, d_g), LT_OK);
    for (int i = 0; i < 4; i++)
        ck_assert_double_eq_tol(d_g[i], far_g[i], TOL);
    ck_assert_double_eq_tol(eval_chamfer_cm2(3, d_p, 4, d_g), 4.449167, TOL);
    ck_assert_double_eq_tol(eval_f_score(3, d_p, 4, d_g, .005).f, .571428, TOL);
    ck_assert_double_eq_tol(eval_f_score(3, d_p, 4, d_g, .010).f, .857143, TOL);
    ck_assert_double_eq_tol(1000 * (eval_mean(3, d_p) + eval_mean(4, d_g)), 17.583333, 1e-5);
}
END_TEST

/* The search against the plain double loop, at sizes around that of a leaf. */
START_TEST(nearest_is_nearest)
{
    static const int size[] = { 1, 2, 3, 7, 8, 9, 64, 131 };
    const int np = size[_i], ng = size[(_i * 3 + 1) % (int)LT_COUNT(size)];
    lt_rng rng = lt_rng_make(11, (uint64_t)_i);
    double p[3 * 131], g[3 * 131], d_p[131], d_g[131];

    for (int i = 0; i < 3 * np; i++)
        p[i] = lt_rng_normal(&rng);
    for (int i = 0; i < 3 * ng; i++)
        g[i] = lt_rng_normal(&rng);
    ck_assert_int_eq(eval_nearest(np, p, ng, g, d_p, d_g), LT_OK);
    for (int i = 0; i < np; i++) {
        double best = INFINITY, d;

        for (int j = 0; j < ng; j++) {
            eval_distances(1, p + 3 * i, g + 3 * j, &d);
            best = fmin(best, d);
        }
        ck_assert_double_eq(d_p[i], best);
    }
    for (int j = 0; j < ng; j++) {
        double back[131];

        ck_assert_int_eq(eval_nearest(1, g + 3 * j, np, p, back, NULL), LT_OK);
        ck_assert_double_eq(d_g[j], back[0]);
    }
}
END_TEST

START_TEST(equal_sets)
{
    double d_p[5], d_g[5], out[15];

    ck_assert_double_eq(eval_mpjpe(5, G, G), 0);
    eval_align_root(5, G, G, 0, out);
    ck_assert_double_eq(eval_mpjpe(5, out, G), 0);
    ck_assert_int_eq(eval_nearest(5, G, 5, G, d_p, d_g), LT_OK);
    ck_assert_double_eq(eval_f_score(5, d_p, 5, d_g, .005).f, 1);
    ck_assert_double_eq(eval_chamfer_cm2(5, d_p, 5, d_g), 0);
}
END_TEST

START_TEST(empty_sets)
{
    double d[5];

    ck_assert_int_eq(eval_nearest(0, NULL, 5, G, NULL, d), LT_OK);
    ck_assert(isinf(d[0]) && isinf(d[4]));
    ck_assert_double_eq(eval_f_score(0, NULL, 5, d, .005).f, 0);
    ck_assert_int_eq(eval_nearest(5, G, 0, NULL, d, NULL), LT_OK);
    ck_assert(isinf(d[0]) && isinf(d[4]));
    ck_assert_double_eq(eval_f_score(5, d, 0, NULL, .005).f, 0);
    ck_assert(isnan(eval_chamfer_cm2(5, d, 0, NULL)));
    ck_assert(isnan(eval_mean(0, NULL)) && isnan(eval_mpjpe(0, NULL, NULL)));
}
END_TEST

START_TEST(not_numbers_are_failures)
{
    double p[15], d[5], d_g[5], out[15];

    memcpy(p, G, sizeof(p));
    p[7] = _i ? NAN : INFINITY;
    ck_assert(!lt_all_finite(15, p) && lt_all_finite(15, G));
    ck_assert(isinf(eval_mpjpe(5, p, G)));
    eval_distances(5, p, G, d);
    ck_assert(isinf(d[2]) && d[1] == 0);
    eval_align_procrustes(EVAL_REFLECT, 5, p, G, out);
    ck_assert(isnan(out[0]) && isnan(out[14]));
    eval_align_scale(5, p, G, 0, 4, out);
    ck_assert(isnan(out[0]) && isnan(out[14]));
    ck_assert_int_eq(eval_nearest(5, p, 5, G, d, d_g), LT_OK);
    ck_assert(isinf(d[2]) && d[0] == 0 && isfinite(d_g[2]) && d_g[2] > 0);
}
END_TEST

START_TEST(no_memory)
{
    double d[5];

    lt_alloc_fail_at(1);
    ck_assert_int_eq(eval_nearest(5, G, 5, G, d, NULL), LT_ENOMEM);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "no memory"));
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_test(t, plain_and_root_relative);
    tcase_add_loop_test(t, procrustes_of_both_kinds, 0, 2);
    tcase_add_test(t, mirror_images);
    tcase_add_test(t, one_point_predictions);
    tcase_add_test(t, scale_and_translation);
    tcase_add_loop_test(t, similarities_are_undone, 0, 10);
    tcase_add_test(t, f_scores);
    tcase_add_test(t, chamfer);
    tcase_add_loop_test(t, nearest_is_nearest, 0, 8);
    tcase_add_test(t, equal_sets);
    tcase_add_test(t, empty_sets);
    tcase_add_loop_test(t, not_numbers_are_failures, 0, 2);
    tcase_add_test(t, no_memory);
}

int main(void)
{
    return run_suite("metrics", add_tests);
}
