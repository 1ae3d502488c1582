/* SPDX-License-Identifier: Apache-2.0 */
/* softmax against torch.softmax. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_softmax(in[0]); }

/* Rows whose exponentials would overflow without the maximum taken off. */
static void high(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (void)c;
    (void)input;
    for (int64_t i = 0; i < n; i++)
        v[i] = (lt_real)(100 + lt_rng_range(r, -3, 3));
}

static const op_case cases[] = {
    { "rows", build, .in = { S(3, 67) } },
    { "one", build, .in = { S(4, 1) } },
    { "high", build, .in = { S(3, 17) }, .fill = high },
    { "deep", build, .in = { S(2, 2, 3, 5) } },
    { "no_rows", build, .in = { S(0, 5) } },
    { "no_columns", build, .in = { S(3, 0) } },
    { "long", build, .in = { S(37, 1025) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { NUMBER }, "softmax: its input is a single number, want a row at least" },
};

const op_suite softmax_suite = { "softmax", CASES(cases), BAD(bad), .vary = vary_first };
