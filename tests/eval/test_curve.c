/* SPDX-License-Identifier: Apache-2.0 */
/* Means, PCK and areas under curves against numbers from NumPy. */
#include "eval/metrics/curve.h"

#include "libtensor/base/arena.h"
#include "tests/suite.h"

#include <math.h>

#define TOL 1e-6

/* Three frames of two keypoints. */
static const double frames[3][2] = { { 0, .005 }, { .010, .020 }, { .060, .049 } };

static eval_pck *fed(double lo, double hi, int n)
{
    eval_pck *pck = eval_pck_new(2, lo, hi, n);

    ck_assert_ptr_nonnull(pck);
    for (int i = 0; i < 3; i++)
        eval_pck_add(pck, frames[i]);
    return pck;
}

START_TEST(pck_values)
{
    static const struct { double lo, hi; int n; double auc; } want[] = {
        { 0, .05, 100, .553872 }, { .02, .05, 100, .672559 }, { 0, .05, 3, .583333 },
    };
    eval_pck *pck = fed(want[_i].lo, want[_i].hi, want[_i].n);

    ck_assert_double_eq_tol(eval_pck_auc(pck), want[_i].auc, TOL);
    ck_assert_double_eq_tol(eval_pck_mean(pck), .024, TOL);
    ck_assert_double_eq_tol(eval_pck_at(pck, want[_i].n - 1), 5. / 6, TOL);
    if (want[_i].lo == 0)
        ck_assert_double_eq_tol(eval_pck_at(pck, 0), 1. / 6, TOL);
    ck_assert_double_eq(eval_pck_threshold(pck, want[_i].n - 1), .05);
    ck_assert_int_eq(eval_pck_failed(pck), 0);
    eval_pck_free(pck);
}
END_TEST

START_TEST(median_of_points)
{
    double median;

    ck_assert_int_eq(eval_median_of_points(3, 2, &frames[0][0], &median), LT_OK);
    ck_assert_double_eq_tol(median, .015, TOL);
    ck_assert_int_eq(eval_median_of_points(0, 2, NULL, &median), LT_OK);
    ck_assert(isnan(median));
}
END_TEST

START_TEST(pck_extremes)
{
    const double perfect[2] = { 0, 0 }, lost[2] = { NAN, INFINITY };
    eval_pck *pck = eval_pck_new(2, 0, .05, 100);

    ck_assert(isnan(eval_pck_auc(pck)) && isnan(eval_pck_mean(pck)) && isnan(eval_pck_at(pck, 0)));
    eval_pck_add(pck, perfect);
    ck_assert_double_eq_tol(eval_pck_auc(pck), 1, 1e-12);
    ck_assert_double_eq(eval_pck_mean(pck), 0);
    eval_pck_add(pck, lost);
    ck_assert_double_eq_tol(eval_pck_auc(pck), .5, 1e-12);
    ck_assert(isnan(eval_pck_mean(pck)));
    ck_assert_int_eq(eval_pck_failed(pck), 1);
    eval_pck_free(pck);
    eval_pck_free(NULL);
}
END_TEST

START_TEST(means_and_shares)
{
    eval_mean_of m = { 0 };
    eval_share s = { 0 };
    const double classes[3] = { .5, NAN, 1 }, none[1] = { NAN };

    ck_assert(isnan(eval_mean_value(&m)) && isnan(eval_share_value(&s)));
    eval_mean_add(&m, 1);
    eval_mean_add(&m, 2);
    ck_assert_double_eq(eval_mean_value(&m), 1.5);
    eval_mean_add(&m, INFINITY);
    ck_assert(isnan(eval_mean_value(&m)));
    ck_assert_int_eq(m.failed, 1);
    eval_share_add(&s, true);
    eval_share_add(&s, false);
    ck_assert_double_eq(eval_share_value(&s), .5);
    ck_assert_double_eq(eval_class_mean(3, classes), .75);
    ck_assert(isnan(eval_class_mean(1, none)));
}
END_TEST

START_TEST(ycb_area)
{
    static const struct { int n; double error[4], ycb, exact; } want[] = {
        { 4, { .005, .02, .04, .15 }, .6875, .5875 }, { 1, { .01 }, 1, .9 },
        { 3, { .03, .01, .02 }, .9, .8 }, { 1, { .2 }, 0, 0 }, { 2, { 0, 0 }, 1, 1 },
        { 3, { NAN, .01, INFINITY }, 1. / 3, .3 }, { 0, { 0 }, NAN, NAN },
    };
    double error[4];
    double area;

    for (int i = 0; i < 4; i++)
        error[i] = want[_i].error[i];
    area = eval_auc_exact(want[_i].n, error, .1);
    if (want[_i].n == 0) {
        ck_assert(isnan(area) && isnan(eval_auc_ycb(0, error, .1)));
        return;
    }
    ck_assert_double_eq_tol(area, want[_i].exact, TOL);
    ck_assert_double_eq_tol(eval_auc_ycb(want[_i].n, error, .1), want[_i].ycb, TOL);
}
END_TEST

START_TEST(no_memory)
{
    double median;

    for (int i = 1; i <= 2; i++) {
        lt_alloc_fail_at(i);
        eval_pck_free(eval_pck_new(778, 0, .05, 100));          /* NULL, or no block was needed */
    }
    lt_alloc_fail_at(1);
    ck_assert_int_eq(eval_median_of_points(3, 2, &frames[0][0], &median), LT_ENOMEM);
    lt_alloc_fail_at(0);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_loop_test(t, pck_values, 0, 3);
    tcase_add_test(t, median_of_points);
    tcase_add_test(t, pck_extremes);
    tcase_add_test(t, means_and_shares);
    tcase_add_loop_test(t, ycb_area, 0, 7);
    tcase_add_test(t, no_memory);
}

int main(void)
{
    return run_suite("curve", add_tests);
}
