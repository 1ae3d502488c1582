/* SPDX-License-Identifier: Apache-2.0 */
/* farthest_point_sampling, by which rows of the first input are gathered, against a loop in NumPy; points of a lattice
 * are equally far. */
#include "tests/ops/suite.h"

static lt_tensor *from(lt_tensor **in, const int32_t *start, int64_t n)
{
    lt_tensor *first = lt_constant(in[0]->graph, LT_I32, LT_SHAPE(lt_dim(in[1], 0)), start);

    return lt_gather(in[0], lt_farthest_point_sampling(in[1], first, n));
}

static lt_tensor *some(lt_tensor **in) { return from(in, (int32_t[]){ 3, 0, 7 }, 5); }
static lt_tensor *all(lt_tensor **in) { return from(in, (int32_t[]){ 1 }, lt_dim(in[1], 1)); }
static lt_tensor *outside(lt_tensor **in) { return from(in, (int32_t[]){ 99, -1 }, 3); }
static lt_tensor *more(lt_tensor **in) { return from(in, (int32_t[]){ 1 }, 6); }
static lt_tensor *no_start(lt_tensor **in) { return lt_gather(in[0], lt_farthest_point_sampling(in[1], NULL, 3)); }
static lt_tensor *none(lt_tensor **in) { return from(in, (int32_t[]){ 1, 1 }, 0); }
static lt_tensor *real_start(lt_tensor **in) { return lt_farthest_point_sampling(in[1], in[0], 2); }

/* Whole numbers from 0 to 3 in x, y and z */
static void fill_lattice(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    if (input == 0)
        fill_clear_of_zero(c, input, v, n, r);
    for (int64_t i = 0; input == 1 && i < n; i++)
        v[i] = (lt_real)(i / 3 >> 2 * (i % 3) & 3);
}

static const op_case cases[] = {
    { "some", some, .in = { S(3, 37, 2), C(3, 37, 3) } },
    { "all", all, .in = { S(1, 19, 2), C(1, 19, 3) } },
    { "one", all, .in = { S(1, 1, 2), C(1, 1, 3) } },
    { "outside", outside, .in = { S(2, 16, 2), C(2, 16, 3) } },
    { "no_start", no_start, .in = { S(2, 11, 2), C(2, 11, 3) } },
    { "more", more, .in = { S(1, 4, 2), C(1, 4, 3) } },
    { "lattice", some, .in = { S(1, 64, 2), C(1, 64, 3) }, .fill = fill_lattice },
    { "long", all, .in = { S(1, 513, 2), C(1, 513, 3) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { some, { S(3, 5, 2), C(3, 5, 2) },
      "farthest_point_sampling: points is (3, 5, 2), want (batch, points, 3) with at least one point" },
    { some, { S(3, 0, 2), C(3, 0, 3) },
      "farthest_point_sampling: points is (3, 0, 3), want (batch, points, 3) with at least one point" },
    { none, { S(2, 5, 2), C(2, 5, 3) }, "farthest_point_sampling: 0 points of each set, want at least one" },
    { real_start, { C(2), C(2, 5, 3) },
      "farthest_point_sampling: start is (2) and no LT_I32, want one integer for each of 2 sets" },
};

const op_suite farthest_point_sampling_suite = { "farthest_point_sampling", CASES(cases), BAD(bad) };
