/* SPDX-License-Identifier: Apache-2.0 */
/* rows against torch.narrow of a padded tensor; what they do to a parameter that is stepped by rows: tests/graph. */
#include "tests/ops/suite.h"

static lt_tensor *from(lt_tensor *x, int32_t first, int64_t n)
{
    return lt_rows(x, lt_constant(x->graph, LT_I32, (lt_shape){ 0 }, &first), n);
}

static lt_tensor *middle(lt_tensor **in) { return from(in[0], 2, 3); }
static lt_tensor *whole(lt_tensor **in) { return from(in[0], 0, lt_dim(in[0], 0)); }
static lt_tensor *numbers(lt_tensor **in) { return from(in[0], 1, 2); }
static lt_tensor *before(lt_tensor **in) { return from(in[0], -2, 3); }
static lt_tensor *behind(lt_tensor **in) { return from(in[0], 3, 4); }
static lt_tensor *outside(lt_tensor **in) { return from(in[0], 9, 2); }
static lt_tensor *none(lt_tensor **in) { return from(in[0], 1, 0); }
static lt_tensor *overlap(lt_tensor **in) { return lt_mul(from(in[0], 0, 3), from(in[0], 2, 3)); }
static lt_tensor *less_than_none(lt_tensor **in) { return from(in[0], 0, -1); }
static lt_tensor *real_place(lt_tensor **in) { return lt_rows(in[0], in[1], 1); }
static lt_tensor *two_places(lt_tensor **in)
{
    return lt_rows(in[0], lt_constant(in[0]->graph, LT_I32, LT_SHAPE(2), (int32_t[]){ 0, 1 }), 1);
}

static const op_case cases[] = {
    { "middle", middle, .in = { S(7, 5) } },
    { "whole", whole, .in = { S(4, 2, 3) } },
    { "numbers", numbers, .in = { S(5) } },
    { "before", before, .in = { S(4, 3) } },
    { "behind", behind, .in = { S(5, 3) } },
    { "outside", outside, .in = { S(3, 2) } },
    { "overlap", overlap, .in = { S(5, 3) } },
    { "none", none, .in = { S(5, 3) }, .no_vectors = true },
    { "long", middle, .in = { S(5, 30011) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { middle, { S(2, 4) }, "rows: 3 rows of 2" },
    { less_than_none, { S(2, 4) }, "rows: -1 rows of 2" },
    { numbers, { NUMBER }, "rows: its input is a number, want rows" },
    { real_place, { S(2, 4), C(1) }, "rows: the first row is (1) and no LT_I32, want one integer" },
    { two_places, { S(2, 4) }, "rows: the first row is (2), want one integer" },
};

static void vary(op_case *c, lt_rng *r)
{
    c->in[0].shape = LT_SHAPE(pick(r, 3, 9), pick(r, 1, 6), pick(r, 1, 9));
}

const op_suite rows_suite = { "rows", CASES(cases), BAD(bad), .vary = vary };
