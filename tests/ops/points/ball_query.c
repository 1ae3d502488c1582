/* SPDX-License-Identifier: Apache-2.0 */
/* ball_query, by which rows of the first input are gathered, against a loop in NumPy; on a lattice points are at the
 * radius. */
#include "tests/ops/suite.h"

static lt_tensor *near(lt_tensor **in, double radius, int64_t n)
{
    return lt_gather(in[0], lt_ball_query(in[1], in[2], radius, n));
}

static lt_tensor *some(lt_tensor **in) { return near(in, 0.9, 7); }
static lt_tensor *many(lt_tensor **in) { return near(in, 5, 3); }
static lt_tensor *unit(lt_tensor **in) { return near(in, 1, 8); }
static lt_tensor *no_radius(lt_tensor **in) { return near(in, 0, 3); }

/* Whole numbers from 0 to 3 in x, y and z */
static void fill_lattice(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    if (input == 0)
        fill_clear_of_zero(c, input, v, n, r);
    for (int64_t i = 0; input > 0 && i < n; i++)
        v[i] = (lt_real)(i / 3 >> 2 * (i % 3) & 3);
}

static const op_case cases[] = {
    { "some", some, .in = { S(2, 53, 2), C(2, 53, 3), C(2, 11, 3) } },
    { "many", many, .in = { S(1, 17, 2), C(1, 17, 3), C(1, 5, 3) } },
    { "one", some, .in = { S(1, 1, 2), C(1, 1, 3), C(1, 1, 3) } },
    { "lattice", unit, .in = { S(1, 64, 2), C(1, 64, 3), C(1, 64, 3) }, .fill = fill_lattice },
    { "long", some, .in = { S(2, 700, 2), C(2, 700, 3), C(2, 90, 3) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { some, { S(2, 5, 2), C(2, 5, 3), C(3, 5, 3) }, "ball_query: points of 2 sets, centres of 3" },
    { some, { S(2, 5, 2), C(2, 5, 3), C(2, 5, 4) },
      "ball_query: centres is (2, 5, 4), want (batch, points, 3) with at least one point" },
    { no_radius, { S(2, 5, 2), C(2, 5, 3), C(2, 5, 3) },
      "ball_query: 3 points within 0, want at least one and a radius above 0" },
};

const op_suite ball_query_suite = { "ball_query", CASES(cases), BAD(bad) };
