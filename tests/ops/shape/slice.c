/* SPDX-License-Identifier: Apache-2.0 */
/* slice against torch.narrow. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_slice(in[0], 1, 1, lt_dim(in[0], 1) - 1); }
static lt_tensor *first(lt_tensor **in) { return lt_slice(in[0], 0, 0, 1); }
static lt_tensor *whole(lt_tensor **in) { return lt_slice(in[0], 0, 0, lt_dim(in[0], 0)); }
static lt_tensor *nothing(lt_tensor **in) { return lt_slice(in[0], 0, 2, 0); }
static lt_tensor *two_of_one(lt_tensor **in)
{
    return lt_mul(lt_slice(in[0], 0, 0, 3), lt_slice(in[0], 0, 2, 3));
}
static lt_tensor *behind(lt_tensor **in) { return lt_slice(in[0], 1, 2, 2); }
static lt_tensor *before(lt_tensor **in) { return lt_slice(in[0], 1, -1, 2); }
static lt_tensor *huge(lt_tensor **in) { return lt_slice(in[0], 1, 1, INT64_MAX); }

static const op_case cases[] = {
    { "middle", build, .in = { S(2, 4, 5) } },
    { "first", first, .in = { S(3, 7) } },
    { "whole", whole, .in = { S(5) } },
    { "nothing", nothing, .in = { S(5, 3) } },
    { "overlap", two_of_one, .in = { S(5, 3) } },
    { "long", build, .in = { S(2, 30, 1001) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { behind, { S(2, 3) }, "slice: 2 elements from 2 are not inside axis 1 of (2, 3)" },
    { before, { S(2, 3) }, "slice: 2 elements from -1 are not inside axis 1 of (2, 3)" },
    { huge, { S(2, 3) }, "slice: 9223372036854775807 elements from 1 are not inside axis 1 of (2, 3)" },
    { build, { S(2) }, "slice: axis 1 is not one of (2)" },
};

static void vary(op_case *c, lt_rng *r)
{
    c->in[0].shape = LT_SHAPE(pick(r, 1, 4), pick(r, 1, 6), pick(r, 1, 9));
}

const op_suite slice_suite = { "slice", CASES(cases), BAD(bad), .vary = vary };
