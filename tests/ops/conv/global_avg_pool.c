/* SPDX-License-Identifier: Apache-2.0 */
/* global_avg_pool against torch.mean. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_global_avg_pool(in[0]); }

static const op_case cases[] = {
    { "map", build, .in = { S(2, 3, 5, 7) } },
    { "one", build, .in = { S(1, 1, 1, 1) } },
    { "empty", build, .in = { S(0, 3, 5, 7) } },
    { "long", build, .in = { S(3, 37, 23, 19) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(3, 5) }, "global_avg_pool: input is (3, 5), want 4 dimensions" },
    { build, { S(1, 3, 0, 5) }, "global_avg_pool: the map is empty" },
};

const op_suite global_avg_pool_suite = { "global_avg_pool", CASES(cases), BAD(bad), .vary = vary_map };
