/* SPDX-License-Identifier: Apache-2.0 */
/* dropout: its gradient under one fixed draw; what the draws are is tests/graph/test_graph.c's. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_dropout(in[0], 0.3); }
static lt_tensor *none(lt_tensor **in) { return lt_dropout(in[0], 0); }
static lt_tensor *after_relu(lt_tensor **in) { return lt_dropout(lt_leaky_relu(in[0], 0.1), 0.3); }
static lt_tensor *all(lt_tensor **in) { return lt_dropout(in[0], 1); }
static lt_tensor *negative(lt_tensor **in) { return lt_dropout(in[0], -0.5); }

static const op_case cases[] = {
    { "rows", build, .in = { S(3, 67) }, .no_vectors = true },
    { "after_relu", after_relu, .in = { S(5, 67) }, .fill = fill_clear_of_zero, .no_vectors = true },
    { "none", none, .in = { S(33) }, .no_vectors = true },
    { "empty", build, .in = { S(0, 7) }, .no_vectors = true },
    { "long", build, .in = { S(40001) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { all, { S(2) }, "dropout: p is 1, want 0 <= p < 1" },
    { negative, { S(2) }, "dropout: p is -0.5, want 0 <= p < 1" },
};

const op_suite dropout_suite = { "dropout", CASES(cases), BAD(bad), .vary = vary_first, .random = true };
