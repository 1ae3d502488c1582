/* SPDX-License-Identifier: Apache-2.0 */
/* sigmoid against torch.sigmoid. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_sigmoid(in[0]); }

/* Far enough out for both tails. */
static void wide(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (void)c;
    (void)input;
    for (int64_t i = 0; i < n; i++)
        v[i] = (lt_real)lt_rng_range(r, -12, 12);
}

static const op_case cases[] = {
    { "one", build, .in = { S(1) } },
    { "rows", build, .in = { S(3, 67) } },
    { "map", build, .in = { S(2, 3, 5, 7) } },
    { "empty", build, .in = { S(0, 7) } },
    { "long", build, .in = { S(40001) }, .no_vectors = true },
    { "wide", build, .in = { S(241) }, .fill = wide },
};

const op_suite sigmoid_suite = { "sigmoid", CASES(cases), .vary = vary_first };
