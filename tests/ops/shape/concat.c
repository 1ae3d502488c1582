/* SPDX-License-Identifier: Apache-2.0 */
/* concat against torch.cat. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_concat(in, 3, 1); }
static lt_tensor *first(lt_tensor **in) { return lt_concat(in, 2, 0); }
static lt_tensor *last(lt_tensor **in) { return lt_concat(in, 2, in[0]->shape.rank - 1); }
static lt_tensor *alone(lt_tensor **in) { return lt_concat(in, 1, 0); }
static lt_tensor *with_itself(lt_tensor **in) { return lt_concat((lt_tensor *[]){ in[0], in[0] }, 2, 0); }

static lt_tensor *many(lt_tensor **in)
{
    lt_tensor *x[LT_MAX_IN + 1];

    for (size_t i = 0; i < LT_COUNT(x); i++)
        x[i] = in[0];
    return lt_concat(x, (int)LT_COUNT(x), 0);
}

static const op_case cases[] = {
    { "three", build, .in = { S(2, 3, 5), S(2, 1, 5), S(2, 4, 5) } },
    { "first", first, .in = { S(2, 7), S(3, 7) } },
    { "last", last, .in = { S(2, 3, 7), S(2, 3, 2) } },
    { "alone", alone, .in = { S(5) } },
    { "itself", with_itself, .in = { S(2, 3) } },
    { "empty", first, .in = { S(0, 7), S(2, 7) } },
    { "long", build, .in = { S(2, 30, 301), S(2, 7, 301), S(2, 1, 301) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { first, { S(2, 7), S(2, 6) }, "concat: (2, 7) and (2, 6) differ in more than axis 0" },
    { first, { S(2, 7), S(2) }, "concat: (2, 7) and (2) differ in more than axis 0" },
    { build, { S(2), S(2), S(2) }, "concat: axis 1 is not one of (2)" },
    { many, { S(2) }, "concat: 13 inputs, at most 12 are possible" },
    { first, { S(2), { OP_NONE, { 0 } } }, "concat: input 1 is missing" },
};

static void vary(op_case *c, lt_rng *r)
{
    const int64_t B = pick(r, 1, 4), n = pick(r, 1, 9);

    for (int i = 0; i < 3; i++)
        c->in[i].shape = LT_SHAPE(B, pick(r, 0, 5), n);
}

const op_suite concat_suite = { "concat", CASES(cases), BAD(bad), .vary = vary };
