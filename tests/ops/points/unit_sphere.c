/* SPDX-License-Identifier: Apache-2.0 */
/* unit_sphere, as a factor of what has a gradient, against NumPy. */
#include "tests/ops/suite.h"

static lt_tensor *all(lt_tensor **in) { return lt_mul(in[0], lt_unit_sphere(in[1], NULL)); }
static lt_tensor *first(lt_tensor **in)
{
    lt_tensor *count = lt_constant(in[0]->graph, LT_I32, LT_SHAPE(2), (int32_t[]){ 5, 99 });

    return lt_mul(in[0], lt_unit_sphere(in[1], count));
}
static lt_tensor *real_count(lt_tensor **in) { return lt_unit_sphere(in[0], in[1]); }

static const op_case cases[] = {
    { "all", all, .in = { S(2, 9, 3), C(2, 9, 3) } },
    { "first", first, .in = { S(2, 8, 3), C(2, 8, 3) } },
    { "one", all, .in = { S(1, 1, 3), C(1, 1, 3) } },
};

static const op_bad_case bad[] = {
    { real_count, { S(2, 5, 3), C(2) },
      "unit_sphere: count is (2) and no LT_I32, want one integer for each of 2 sets" },
    { real_count, { S(5, 3), C(2) }, "unit_sphere: points is (5, 3), want 3 dimensions" },
};

const op_suite unit_sphere_suite = { "unit_sphere", CASES(cases), BAD(bad) };
