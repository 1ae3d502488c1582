/* SPDX-License-Identifier: Apache-2.0 */
/* max against torch.amax, on values that are all different. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_max(in[0]); }

static const op_case cases[] = {
    { "rows", build, .in = { S(3, 67) }, .fill = fill_apart },
    { "maps", build, .in = { S(2, 3, 5, 32) }, .fill = fill_apart },
    { "short", build, .in = { S(9, 5) }, .fill = fill_apart },
    { "one", build, .in = { S(1, 1) }, .fill = fill_apart },
    { "row", build, .in = { S(17) }, .fill = fill_apart },
    { "no_rows", build, .in = { S(0, 4) }, .fill = fill_apart, .no_vectors = true },
    { "long", build, .in = { S(700, 33) }, .fill = fill_apart, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(3, 0) }, "max: its last dimension is empty" },
    { build, { NUMBER }, "max: its last dimension is empty" },
};

static void vary(op_case *c, lt_rng *r) { vary_first(c, r); }

const op_suite max_suite = { "max", CASES(cases), BAD(bad), .vary = vary };
