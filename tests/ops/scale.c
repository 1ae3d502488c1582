/* SPDX-License-Identifier: Apache-2.0 */
/* scale: a number known while recording. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_scale(in[0], -2.5); }
static lt_tensor *by_zero(lt_tensor **in) { return lt_scale(in[0], 0); }

static const op_case cases[] = {
    { "rows", build, .in = { S(3, 67) } },
    { "number", build, .in = { NUMBER } },
    { "zero", by_zero, .in = { S(5) } },
    { "empty", build, .in = { S(0, 7) } },
    { "long", build, .in = { S(40001) }, .no_vectors = true },
};

const op_suite scale_suite = { "scale", CASES(cases), .vary = vary_first };
