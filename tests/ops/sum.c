/* SPDX-License-Identifier: Apache-2.0 */
/* sum of all elements. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_sum(in[0]); }

static const op_case cases[] = {
    { "rows", build, .in = { S(3, 67) } },
    { "number", build, .in = { NUMBER } },
    { "empty", build, .in = { S(0, 7) } },
    { "long", build, .in = { S(40001) }, .no_vectors = true },
};

const op_suite sum_suite = { "sum", CASES(cases), .vary = vary_first };
