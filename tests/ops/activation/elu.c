/* SPDX-License-Identifier: Apache-2.0 */
/* elu against torch.nn.functional.elu. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_elu(in[0]); }

static const op_case cases[] = {
    { "one", build, .in = { S(1) } },
    { "rows", build, .in = { S(3, 67) } },
    { "map", build, .in = { S(2, 3, 5, 7) } },
    { "empty", build, .in = { S(0, 7) } },
    { "long", build, .in = { S(40001) }, .no_vectors = true },
};

const op_suite elu_suite = { "elu", CASES(cases), .vary = vary_first };
