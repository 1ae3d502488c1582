/* SPDX-License-Identifier: Apache-2.0 */
/* soft_argmax2d: expected places, against torch sums. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_soft_argmax2d(in[0]); }

static const op_case cases[] = {
    { "map", build, .in = { S(2, 3, 5, 7) } },
    { "one", build, .in = { S(1, 1, 1, 1) } },
    { "empty", build, .in = { S(0, 3, 5, 7) } },
    { "long", build, .in = { S(3, 21, 32, 33) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(3, 5) }, "soft_argmax2d: heat maps is (3, 5), want 4 dimensions" },
    { build, { S(0, 1, 2147483648, 2147483648) },
      "soft_argmax2d: maps of 2147483648 x 2147483648 cells, want at most 2147483647" },
};

const op_suite soft_argmax2d_suite = { "soft_argmax2d", CASES(cases), BAD(bad), .vary = vary_map };
