/* SPDX-License-Identifier: Apache-2.0 */
/* Alignments, against numbers computed with the datasets' own scoring formulas in double precision. */
#include "libtensor/base/rng.h"
#include "libtensor/geometry/procrustes.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

enum { N = 5 };

static const double truth[3 * N] = { 0, 0, 0, .1, 0, 0, 0, .1, 0, 0, 0, .1, .05, .05, .02 };

/* 1.5 Rz(30 degrees) truth + (0.3, -0.2, 0.5), and the last point 1 cm off */
static void prediction(double x[3 * N])
{
    const double aa[3] = { 0, 0, M_PI / 6 };
    lt_similarity s = { .scale = 1.5, .t = { .3, -.2, .5 } };

    lt_rot_from_axis_angle(aa, s.R);
    lt_similarity_apply(&s, N, truth, x);
    x[12] += 0.01;
}

static double mean_distance(const double *a, const double *b)
{
    double sum = 0;

    for (int i = 0; i < N; i++)
        sum += lt_vec3_distance(a + 3 * i, b + 3 * i) / N;
    return sum;
}

static void expect_near(const double *got, const double *want, int n, double tol)
{
    for (int i = 0; i < n; i++)
        ck_assert_msg(fabs(got[i] - want[i]) <= tol, "[%d] is %.9g, want %.9g", i, got[i], want[i]);
}

START_TEST(both_on_v5)
{
    static const double want[3 * N] = {
        -.000697, .000388, .000106, .098944, .001541, .000136, -.001850, .100029, .000001,
        -.000729, .000492, .099754, .054332, .047551, .020003,
    };
    const double R[9] = { .871752, .489947, -.000315, -.489947, .871752, .001051, .000790, -.000762, .999999 };
    const double t[3] = { -.109233, .213507, -.332312 };
    double x[3 * N], y[3 * N];
    lt_similarity a, b;

    prediction(x);
    ck_assert_double_eq_tol(mean_distance(x, truth), .612766, 6e-7);
    ck_assert_int_eq(lt_procrustes_ho3d(N, x, truth, &a), LT_OK);
    ck_assert_int_eq(lt_procrustes_umeyama(N, x, truth, &b), LT_OK);
    lt_similarity_apply(&a, N, x, y);
    expect_near(y, want, 3 * N, 6e-7);
    lt_similarity_apply(&b, N, x, y);
    expect_near(y, want, 3 * N, 6e-7);
    ck_assert_double_eq_tol(mean_distance(y, truth), .002083, 6e-7);
    ck_assert_double_eq_tol(b.scale, .664318, 6e-7);
    expect_near(b.R, R, 9, 6e-7);
    expect_near(b.t, t, 3, 6e-7);
}
END_TEST

START_TEST(mirror)
{
    double x[3 * N], y[3 * N];
    lt_similarity s;

    for (int i = 0; i < 3 * N; i++)
        x[i] = i % 3 == 0 ? -truth[i] : truth[i];
    lt_procrustes_ho3d(N, x, truth, &s);
    lt_similarity_apply(&s, N, x, y);
    ck_assert_double_eq_tol(mean_distance(y, truth), 0, 1e-7);
    lt_procrustes_umeyama(N, x, truth, &s);
    ck_assert_double_eq_tol(s.scale, .744445, 6e-7);
    ck_assert_double_eq_tol(lt_mat3_det(s.R), 1, 1e-14);
    lt_similarity_apply(&s, N, x, y);
    ck_assert_double_eq_tol(mean_distance(y, truth), .039883, 6e-7);
}
END_TEST

START_TEST(zero_prediction)
{
    const double x[3 * N] = { 0 };
    double y[3 * N];
    lt_similarity s;

    lt_procrustes_ho3d(N, x, truth, &s);
    lt_similarity_apply(&s, N, x, y);
    ck_assert_double_eq_tol(mean_distance(y, truth), .064810, 6e-7);
    lt_procrustes_umeyama(N, x, truth, &s);
    lt_similarity_apply(&s, N, x, y);
    ck_assert_double_eq_tol(mean_distance(y, truth), .064810, 6e-7);
    lt_align_scale_translation(N, x, truth, 0, 4, y);
    ck_assert_double_eq_tol(mean_distance(y, truth), .074697, 6e-7);
}
END_TEST

/* Equal points anywhere: no scale is made of what rounding leaves about their mean. */
START_TEST(equal_points_have_no_scale)
{
    lt_rng r = lt_rng_make(2, 0);

    for (int trial = 0; trial < 1000; trial++) {
        const int n = 1 + trial % 40;
        double x[3 * 40], y[3 * 40], far[3] = { 1, 2, 3 }, out[3];
        lt_similarity s;

        for (int i = 0; i < 3 * n; i++) {
            x[i] = i < 3 ? lt_rng_normal(&r) : x[i % 3];
            y[i] = lt_rng_normal(&r);
        }
        ck_assert_int_eq(lt_procrustes_umeyama(n, x, y, &s), LT_OK);
        ck_assert_double_eq(s.scale, 0);
        lt_similarity_apply(&s, 1, far, out);
        expect_near(out, s.t, 3, 0);
    }
}
END_TEST

START_TEST(scale_and_translation)
{
    static const double want[3 * N] = {
        0, 0, 0, .084378, .048716, 0, -.048716, .084378, 0, 0, 0, .097432, .024327, .066547, .019486,
    };
    double x[3 * N];

    prediction(x);
    ck_assert_int_eq(lt_align_scale_translation(N, x, truth, 0, 4, x), LT_OK);      /* in place */
    expect_near(x, want, 3 * N, 6e-7);
    ck_assert_double_eq_tol(mean_distance(x, truth), .027087, 6e-7);
    ck_assert_int_eq(lt_align_scale_translation(N, x, truth, 0, N, x), LT_EINVAL);
}
END_TEST

START_TEST(rigid_recovers_motion)
{
    lt_rng r = lt_rng_make(1, 0);

    for (int trial = 0; trial < 100; trial++) {
        lt_similarity motion = { .scale = 1 }, found;
        double x[3 * N], y[3 * N], q[4];
        for (int i = 0; i < 4; i++)
            q[i] = lt_rng_normal(&r);
        lt_rot_from_quat(q, motion.R);
        for (int i = 0; i < 3; i++)
            motion.t[i] = lt_rng_normal(&r);
        for (int i = 0; i < 3 * N; i++)
            x[i] = lt_rng_normal(&r);
        lt_similarity_apply(&motion, N, x, y);
        ck_assert_int_eq(lt_procrustes_rigid(N, x, y, &found), LT_OK);
        expect_near(found.R, motion.R, 9, 1e-13);
        expect_near(found.t, motion.t, 3, 1e-13);
        ck_assert_double_eq(found.scale, 1);
    }
}
END_TEST

/* One point, two, points on a line: a finite answer that is as good as can be. NaN: a status. */
START_TEST(degenerate)
{
    const double line[9] = { 0, 0, 0, 1, 1, 1, 2, 2, 2 }, line_y[9] = { 0, 0, 0, 0, 0, 1, 0, 0, 2 };
    double bad[9] = { 0, 0, NAN }, out[9];
    lt_similarity s;

    for (int n = 1; n <= 3; n++) {
        ck_assert_int_eq(lt_procrustes_rigid(n, line, line, &s), LT_OK);
        lt_similarity_apply(&s, n, line, out);
        expect_near(out, line, 3 * n, 1e-14);
    }
    ck_assert_int_eq(lt_procrustes_umeyama(3, line, line_y, &s), LT_OK);
    lt_similarity_apply(&s, 3, line, out);
    expect_near(out, line_y, 9, 1e-14);
    ck_assert_int_eq(lt_procrustes_umeyama(3, bad, line, &s), LT_EINVAL);
    ck_assert_int_eq(lt_procrustes_ho3d(3, line, bad, &s), LT_EINVAL);
    ck_assert_int_eq(lt_procrustes_rigid(0, line, line, &s), LT_EINVAL);
    ck_assert_int_eq(lt_align_scale_translation(3, bad, line, 0, 1, out), LT_EINVAL);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_test(c, both_on_v5);
    tcase_add_test(c, mirror);
    tcase_add_test(c, zero_prediction);
    tcase_add_test(c, equal_points_have_no_scale);
    tcase_add_test(c, scale_and_translation);
    tcase_add_test(c, rigid_recovers_motion);
    tcase_add_test(c, degenerate);
}

int main(void)
{
    return run_suite("procrustes", add_tests);
}
