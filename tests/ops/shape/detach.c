/* SPDX-License-Identifier: Apache-2.0 */
/* detach: the values pass and the gradient does not, beside a path that it takes. */
#include "tests/ops/suite.h"

/* d(x * stop(y)): x has a gradient and y, a constant to the check, has none. */
static lt_tensor *build(lt_tensor **in) { return lt_mul(in[0], lt_detach(in[1])); }

static const op_case cases[] = {
    { "beside", build, .in = { S(3, 5), C(3, 5) } },
    { "empty", build, .in = { S(0), C(0) } },
};

const op_suite detach_suite = { "detach", CASES(cases) };
