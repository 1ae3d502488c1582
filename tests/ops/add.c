/* SPDX-License-Identifier: Apache-2.0 */
/* add with NumPy's broadcasting, against torch. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_add(in[0], in[1]); }
static lt_tensor *with_itself(lt_tensor **in) { return lt_add(in[0], in[0]); }

static const op_case cases[] = {
    { "same", build, .in = { S(2, 3, 5), S(2, 3, 5) } },
    { "row", build, .in = { S(4, 67), S(67) } },
    { "column", build, .in = { S(5, 33), S(5, 1) } },
    { "channel", build, .in = { S(2, 3, 4, 5), S(1, 3, 1, 1) } },
    { "crossed", build, .in = { S(3, 1, 5), S(4, 1) } },
    { "left", build, .in = { S(1, 3), S(2, 5, 3) } },
    { "number", build, .in = { S(2, 19), NUMBER } },
    { "numbers", build, .in = { NUMBER, NUMBER } },
    { "gate", build, .in = { S(2, 3, 4, 4), S(2, 3, 1, 1) } },
    { "itself", with_itself, .in = { S(3, 17) } },
    { "empty", build, .in = { S(0, 3), S(1, 3) } },
    { "long", build, .in = { S(2, 20011), S(20011) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 3), S(2, 4) }, "add: (2, 3) and (2, 4) do not broadcast" },
    { build, { S(2, 3), S(2, 3, 1, 2) }, "add: (2, 3) and (2, 3, 1, 2) do not broadcast" },
};

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

const op_suite add_suite = { "add", CASES(cases), BAD(bad), .vary = vary };
