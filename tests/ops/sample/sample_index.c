/* SPDX-License-Identifier: Apache-2.0 */
/* sample_index: added to what has a gradient; itself it has none. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_add(in[0], lt_mul(in[1], lt_sample_index(in[1]))); }
static lt_tensor *alone(lt_tensor **in) { return lt_sample_index(in[0]); }

static void fill_ones(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (void)c;
    for (int64_t i = 0; i < n; i++)
        v[i] = input == 1 ? 1 : (lt_real)lt_rng_range(r, -1, 1);
}

static const op_case cases[] = {
    { "beside", build, .in = { S(3, 5), C(3, 5) }, .fill = fill_ones },
    { "one", build, .in = { S(1, 2), C(1, 2) }, .fill = fill_ones },
    { "empty", build, .in = { S(0, 2), C(0, 2) }, .fill = fill_ones },
};

static const op_bad_case bad[] = {
    { alone, .in = { NUMBER }, .message = "sample_index: its input has no dimension for samples" },
};

const op_suite sample_index_suite = { "sample_index", CASES(cases), BAD(bad) };
