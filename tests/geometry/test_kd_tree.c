/* SPDX-License-Identifier: Apache-2.0 */
/* The tree against going through all points, bit by bit. */
#include "libtensor/base/arena.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/kd_tree.h"
#include "tests/suite.h"

enum { MOST = 1000, QUERIES = 200 };

static double through_all(int n, const double *points, const double *p)
{
    double least = INFINITY;

    for (int i = 0; i < n; i++)
        least = fmin(least, lt_vec3_distance(p, points + 3 * i));
    return least;
}

static void expect_nearest(int n, const double *points, int m, const double *queries)
{
    lt_kd_tree t;

    ck_assert_int_eq(lt_kd_tree_new(n, points, &t), LT_OK);
    for (int i = 0; i < m; i++)
        ck_assert_double_eq(lt_kd_tree_distance(&t, queries + 3 * i), through_all(n, points, queries + 3 * i));
    lt_kd_tree_free(&t);
}

static void draw(double *p, int n, lt_rng *rng, double scale)
{
    for (int i = 0; i < 3 * n; i++)
        p[i] = scale * lt_rng_normal(rng);
}

START_TEST(nearest_of_scattered_points)
{
    static const int size[] = { 1, 2, 15, 16, 17, 18, 31, 32, 33, 34, 100, 257, MOST };
    static double points[3 * MOST], queries[3 * QUERIES];
    const int n = size[_i];
    lt_rng rng = lt_rng_make(5, (uint64_t)_i);

    draw(points, n, &rng, 0.1);
    draw(queries, QUERIES, &rng, 0.15);
    expect_nearest(n, points, QUERIES, queries);
    expect_nearest(n, points, n, points);
}
END_TEST

/* Sorted, equal along one axis or along all of them, and with many ties: halves part equal numbers. */
START_TEST(nearest_of_regular_points)
{
    static double points[3 * MOST], queries[3 * QUERIES];
    lt_rng rng = lt_rng_make(6, (uint64_t)_i);

    for (int i = 0; i < MOST; i++) {
        points[3 * i] = _i < 2 ? i : _i == 2 ? 1 : i % 10;
        points[3 * i + 1] = _i == 0 ? -i : _i == 1 ? 0 : _i == 2 ? 1 : i / 10 % 10;
        points[3 * i + 2] = _i < 2 ? 3 : _i == 2 ? 1 : i / 100;
    }
    for (int i = 0; i < 3 * QUERIES; i++)
        queries[i] = floor(24 * lt_rng_uniform(&rng) - 2) / 2;
    expect_nearest(MOST, points, QUERIES, queries);
}
END_TEST

/* The next of all that come behind *last: by distance, then by index */
static lt_kd_neighbour next_of_all(int n, const double *points, const double *p, const lt_kd_neighbour *last)
{
    lt_kd_neighbour best = { INFINITY, n };

    for (int i = 0; i < n; i++) {
        double d[3], square;

        lt_vec3_sub(p, points + 3 * i, d);
        square = lt_vec3_dot(d, d);
        if ((square > last->square || (square == last->square && i > last->index)) && square < best.square)
            best = (lt_kd_neighbour){ square, i };
    }
    return best;
}

/* On a lattice, where many are equally far, and among scattered points */
START_TEST(the_nearest_few)
{
    enum { K = 7 };
    static double points[3 * MOST], queries[3 * QUERIES];
    const int n = _i < 2 ? MOST : 5;
    lt_rng rng = lt_rng_make(7, (uint64_t)_i);
    lt_kd_neighbour found[K];
    lt_kd_tree t;

    draw(points, n, &rng, _i ? 0.1 : 3);
    draw(queries, QUERIES, &rng, _i ? 0.1 : 3);
    for (int i = 0; _i == 0 && i < 3 * MOST; i++)
        points[i] = floor(points[i]);
    for (int i = 0; _i == 0 && i < 3 * QUERIES; i++)
        queries[i] = floor(queries[i]);
    ck_assert_int_eq(lt_kd_tree_new(n, points, &t), LT_OK);
    for (int i = 0; i < QUERIES; i++) {
        lt_kd_neighbour last = { -1, 0 };

        ck_assert_int_eq(lt_kd_tree_nearest(&t, queries + 3 * i, K, found), n < K ? n : K);
        for (int k = 0; k < (n < K ? n : K); k++) {
            last = next_of_all(n, points, queries + 3 * i, &last);
            ck_assert_int_eq(found[k].index, last.index);
            ck_assert_double_eq(found[k].square, last.square);
        }
    }
    ck_assert_int_eq(lt_kd_tree_nearest(&t, (double[]){ NAN, 0, 0 }, K, found), 0);
    lt_kd_tree_free(&t);
}
END_TEST

START_TEST(far_and_no_numbers)
{
    static const double points[] = { 1e200, 0, 0, NAN, 0, 0, 0, INFINITY, 0, 0, 0, 2, -1e308, 0, 0, 1e308, 0, 0 };
    static const double none[] = { NAN, 1, 1, 1, -INFINITY, 1 };
    const double near[] = { 0, 0, 0 }, far[] = { 1e200, 1, 0 }, nowhere[] = { 0, NAN, 0 }, beyond[] = { 0, -1e300, 0 };
    lt_kd_tree t;

    ck_assert_int_eq(lt_kd_tree_new(6, points, &t), LT_OK);
    ck_assert_int_eq(t.n, 4);
    ck_assert_double_eq(lt_kd_tree_distance(&t, near), 2);
    ck_assert_double_eq(lt_kd_tree_distance(&t, far), 1);
    ck_assert(isinf(lt_kd_tree_distance(&t, nowhere)) && isinf(lt_kd_tree_distance(&t, beyond)));
    lt_kd_tree_free(&t);
    ck_assert_int_eq(lt_kd_tree_new(2, none, &t), LT_OK);
    ck_assert(isinf(lt_kd_tree_distance(&t, near)));
    lt_kd_tree_free(&t);
    ck_assert_int_eq(lt_kd_tree_new(0, NULL, &t), LT_OK);
    ck_assert(isinf(lt_kd_tree_distance(&t, near)));
    lt_kd_tree_free(&t);
    lt_kd_tree_free(&t);
}
END_TEST

START_TEST(no_memory)
{
    static const double points[3 * 20];
    lt_kd_tree t;

    lt_alloc_fail_at(_i);
    ck_assert_int_eq(lt_kd_tree_new(20, points, &t), LT_ENOMEM);
    ck_assert_str_eq(lt_last_error(), "nearest neighbours of 20 points: no memory");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_loop_test(tc, nearest_of_scattered_points, 0, 13);
    tcase_add_loop_test(tc, nearest_of_regular_points, 0, 4);
    tcase_add_loop_test(tc, the_nearest_few, 0, 3);
    tcase_add_test(tc, far_and_no_numbers);
    tcase_add_loop_test(tc, no_memory, 1, 3);
}

int main(void)
{
    return run_suite("kd_tree", add_tests);
}
