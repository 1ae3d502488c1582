/* SPDX-License-Identifier: Apache-2.0 */
/* linear against torch.nn.functional.linear. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_linear(in[0], in[1], in[2]); }

static const op_case cases[] = {
    { "rows", build, .in = { S(3, 7), S(5, 7), S(5) } },
    { "no_bias", build, .in = { S(3, 7), S(5, 7) } },
    { "vector", build, .in = { S(9), S(4, 9), S(4) } },
    { "deep", build, .in = { S(2, 3, 67), S(17, 67), S(17) } },
    { "one", build, .in = { S(1, 1), S(1, 1), S(1) } },
    { "no_rows", build, .in = { S(0, 7), S(5, 7), S(5) } },
    { "no_features", build, .in = { S(3, 0), S(5, 0), S(5) } },
    { "long", build, .in = { S(130, 129), S(131, 129), S(131) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(3, 8), S(5, 7), S(5) }, "linear: input has 8 features, weight wants 7" },
    { build, { NUMBER, S(5, 7), S(5) }, "linear: input has 0 features, weight wants 7" },
    { build, { S(3, 7), S(5, 7), S(7) }, "linear: bias is (7), want (5)" },
    { build, { S(3, 7), S(7), S(5) }, "linear: weight is (7), want 2 dimensions" },
    { build, { S(3, 7) }, "linear: input 1 is missing" },
    { build, { { OP_NONE, { 0 } }, S(5, 7), S(5) }, "linear: input 0 is missing" },
};

static void vary(op_case *c, lt_rng *r)
{
    const int64_t K = pick(r, 0, 20), N = pick(r, 1, 20);

    c->in[0].shape = LT_SHAPE(pick(r, 0, 4), pick(r, 1, 20), K);
    c->in[1].shape = LT_SHAPE(N, K);
    c->in[2].shape = LT_SHAPE(N);
}

const op_suite linear_suite = { "linear", CASES(cases), BAD(bad), .vary = vary };
