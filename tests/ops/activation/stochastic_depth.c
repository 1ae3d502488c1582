/* SPDX-License-Identifier: Apache-2.0 */
/* stochastic_depth: its gradient under one fixed draw; what the draws are is tests/graph/test_graph.c's. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_stochastic_depth(in[0], 0.3); }
static lt_tensor *none(lt_tensor **in) { return lt_stochastic_depth(in[0], 0); }
static lt_tensor *all(lt_tensor **in) { return lt_stochastic_depth(in[0], 1); }

static const op_case cases[] = {
    { "maps", build, .in = { S(9, 3, 5, 7) }, .no_vectors = true },
    { "rows", build, .in = { S(33) }, .no_vectors = true },
    { "none", none, .in = { S(3, 11) }, .no_vectors = true },
    { "no_samples", build, .in = { S(0, 7) }, .no_vectors = true },
    { "long", build, .in = { S(5, 20001) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { all, { S(2) }, "stochastic_depth: p is 1, want 0 <= p < 1" },
    { build, { NUMBER }, "stochastic_depth: its input is a single number, want samples along a dimension" },
};

const op_suite stochastic_depth_suite = {
    "stochastic_depth", CASES(cases), BAD(bad), .vary = vary_first, .random = true,
};
