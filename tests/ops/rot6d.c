/* SPDX-License-Identifier: Apache-2.0 */
/* rot6d against torch.nn.functional.normalize and torch.cross. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_rot6d(in[0]); }

static const op_case cases[] = {
    { "joints", build, .in = { S(2, 16, 6) } },
    { "one", build, .in = { S(6) } },
    { "empty", build, .in = { S(0, 6) } },
    { "long", build, .in = { S(1500, 6) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 5) }, "rot6d: its input is (2, 5), want (..., 6)" },
    { build, { NUMBER }, "rot6d: its input is (), want (..., 6)" },
    { build, { S(1, 1, 1, 1, 1, 6) }, "rot6d: its input is (1, 1, 1, 1, 1, 6), want (..., 6)" },
};

static void vary(op_case *c, lt_rng *r)
{
    c->in[0].shape = LT_SHAPE(pick(r, 1, 4), pick(r, 1, 9), 6);
}

const op_suite rot6d_suite = { "rot6d", CASES(cases), BAD(bad), .vary = vary };
