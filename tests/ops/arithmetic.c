/* SPDX-License-Identifier: Apache-2.0 */
/* add, sub and mul with NumPy's broadcasting, against torch. */
#include "tests/ops/suite.h"

static lt_tensor *add(lt_tensor **in) { return lt_add(in[0], in[1]); }
static lt_tensor *sub(lt_tensor **in) { return lt_sub(in[0], in[1]); }
static lt_tensor *mul(lt_tensor **in) { return lt_mul(in[0], in[1]); }
static lt_tensor *add_itself(lt_tensor **in) { return lt_add(in[0], in[0]); }
static lt_tensor *sub_itself(lt_tensor **in) { return lt_sub(in[0], in[0]); }
static lt_tensor *mul_itself(lt_tensor **in) { return lt_mul(in[0], in[0]); }

#define OP_CASES(op) {                                                                              \
    { "same", op, .in = { S(2, 3, 5), S(2, 3, 5) } },                                               \
    { "row", op, .in = { S(4, 67), S(67) } },                                                       \
    { "column", op, .in = { S(5, 33), S(5, 1) } },                                                  \
    { "channel", op, .in = { S(2, 3, 4, 5), S(1, 3, 1, 1) } },                                      \
    { "crossed", op, .in = { S(3, 1, 5), S(4, 1) } },                                               \
    { "left", op, .in = { S(1, 3), S(2, 5, 3) } },                                                  \
    { "number", op, .in = { S(2, 19), NUMBER } },                                                   \
    { "numbers", op, .in = { NUMBER, NUMBER } },                                                    \
    { "gate", op, .in = { S(2, 3, 4, 4), S(2, 3, 1, 1) } },                                         \
    { "itself", op##_itself, .in = { S(3, 17) } },                                                  \
    { "empty", op, .in = { S(0, 3), S(1, 3) } },                                                    \
    { "long", op, .in = { S(2, 20011), S(20011) }, .no_vectors = true },                            \
}

static const op_case add_cases[] = OP_CASES(add), sub_cases[] = OP_CASES(sub), mul_cases[] = OP_CASES(mul);

#define OP_BAD(op) {                                                                                \
    { op, { S(2, 3), S(2, 4) }, #op ": (2, 3) and (2, 4) do not broadcast" },                       \
    { op, { S(2, 3), S(2, 3, 1, 2) }, #op ": (2, 3) and (2, 3, 1, 2) do not broadcast" },           \
}

static const op_bad_case add_bad[] = OP_BAD(add), sub_bad[] = OP_BAD(sub), mul_bad[] = OP_BAD(mul);

/* Any dimension of either operand may be 1, and the second may lack some of the first. */
static void vary(op_case *c, lt_rng *r)
{
    lt_shape *a = &c->in[0].shape, *b = &c->in[1].shape;

    vary_first(c, r);
    b->rank = (int)pick(r, 0, a->rank);
    for (int i = 0; i < b->rank; i++)
        b->dim[i] = a->dim[a->rank - b->rank + i];
    for (int i = 0; i < b->rank; i++)
        if (lt_rng_below(r, 3) == 0)
            b->dim[i] = 1;
    for (int i = 0; i < a->rank; i++)
        if (lt_rng_below(r, 4) == 0)
            a->dim[i] = 1;
}

const op_suite add_suite = { "add", CASES(add_cases), BAD(add_bad), .vary = vary };
const op_suite sub_suite = { "sub", CASES(sub_cases), BAD(sub_bad), .vary = vary };
const op_suite mul_suite = { "mul", CASES(mul_cases), BAD(mul_bad), .vary = vary };
