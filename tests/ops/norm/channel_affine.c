/* SPDX-License-Identifier: Apache-2.0 */
/* channel_affine: one scale and shift for each of dimension 1. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_channel_affine(in[0], in[1], in[2]); }

static const op_case cases[] = {
    { "map", build, .in = { S(2, 3, 5, 7), S(3), S(3) } },
    { "rows", build, .in = { S(4, 5), S(5), S(5) } },
    { "empty", build, .in = { S(0, 5, 3), S(5), S(5) } },
    { "long", build, .in = { S(4, 9, 31, 33), S(9), S(9) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(7), S(7), S(7) }, "channel_affine: its input has no dimension 1 for channels" },
    { build, { S(2, 3), S(2), S(3) }, "channel_affine: scale is (2), want (3)" },
    { build, { S(2, 3), S(3), S(3, 1) }, "channel_affine: shift is (3, 1), want (3)" },
};

static void vary(op_case *c, lt_rng *r)
{
    const int64_t channels = pick(r, 1, 6);

    c->in[0].shape = LT_SHAPE(pick(r, 0, 4), channels, pick(r, 1, 9));
    c->in[1].shape = c->in[2].shape = LT_SHAPE(channels);
}

const op_suite channel_affine_suite = { "channel_affine", CASES(cases), BAD(bad), .vary = vary };
