/* SPDX-License-Identifier: Apache-2.0 */
/* layer_norm against torch.nn.functional.layer_norm. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_layer_norm(in[0], in[1], in[2], 1e-5); }
static lt_tensor *no_eps(lt_tensor **in) { return lt_layer_norm(in[0], in[1], in[2], 0); }

static const op_case cases[] = {
    { "rows", build, .in = { S(2, 3, 8), S(8), S(8) } },
    { "one_row", build, .in = { S(5), S(5), S(5) } },
    { "prime", build, .in = { S(5, 67), S(67), S(67) } },
    { "no_rows", build, .in = { S(0, 7), S(7), S(7) } },
    { "no_columns", build, .in = { S(3, 0), S(0), S(0) } },
    { "long", build, .in = { S(101, 257), S(257), S(257) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 8), S(8), S(7) }, "layer_norm: bias is (7), want (8)" },
    { build, { S(2, 8), S(7), S(8) }, "layer_norm: weight is (7), want (8)" },
    { build, { NUMBER, S(1), S(1) }, "layer_norm: its input is a single number, want a row at least" },
    { no_eps, { S(2, 8), S(8), S(8) }, "layer_norm: eps is 0, want a number above 0" },
    { build, { S(2, 8), S(8) }, "layer_norm: input 2 is missing" },
};

static void vary(op_case *c, lt_rng *r)
{
    const int64_t n = pick(r, 4, 40);

    c->in[0].shape = LT_SHAPE(pick(r, 0, 3), pick(r, 1, 9), n);
    c->in[1].shape = c->in[2].shape = LT_SHAPE(n);
}

const op_suite layer_norm_suite = { "layer_norm", CASES(cases), BAD(bad), .vary = vary };
