/* SPDX-License-Identifier: Apache-2.0 */
/* cross_entropy against torch, with and without weights of the samples; targets need not sum to 1. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_cross_entropy(in[0], in[1], in[2]); }

/* Targets whose rows sum to about 1, the first 0; weights of 0.5 and more, the second 0. */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    const lt_shape *s = &c->in[1].shape;

    (input == 0 ? fill_clear_of_zero : fill_positive)(c, input, v, n, r);
    for (int64_t i = 0; input == 1 && i < n; i++)
        v[i] = i ? v[i] / (lt_real)s->dim[s->rank - 1] : 0;
    if (input == 2 && n > 1)
        v[1] = 0;
}

static const op_case cases[] = {
    { "weighed", build, .in = { S(3, 4, 5), S(3, 4, 5), C(3) }, .fill = fill },
    { "plain", build, .in = { S(3, 67), S(3, 67) }, .fill = fill },
    { "target", build, .in = { S(2, 3, 5), C(2, 3, 5), C(2) }, .fill = fill },
    { "one", build, .in = { S(1, 1), S(1, 1) }, .fill = fill },
    { "empty", build, .in = { S(0, 4), S(0, 4) }, .fill = fill, .no_vectors = true },
    { "no rows", build, .in = { S(2, 0, 4), S(2, 0, 4) }, .fill = fill, .no_vectors = true },
    { "long", build, .in = { S(5, 21, 256), S(5, 21, 256), C(5) }, .fill = fill, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 3), S(3, 2) }, "cross_entropy: second operand is (3, 2), want (2, 3)" },
    { build, { S(2, 3), S(2, 3), C(3) }, "cross_entropy: weight is (3), want (2)" },
    { build, { S(3), S(3) }, "cross_entropy: logits is (3), want samples and at least one class" },
    { build, { S(3, 0), S(3, 0) }, "cross_entropy: logits is (3, 0), want samples and at least one class" },
};

static void vary(op_case *c, lt_rng *r)
{
    const int64_t samples = pick(r, 0, 9);

    c->in[0].shape = c->in[1].shape = LT_SHAPE(samples, pick(r, 0, 5), pick(r, 1, 99));
    c->in[2].shape = LT_SHAPE(samples);
}

const op_suite cross_entropy_suite = { "cross_entropy", CASES(cases), BAD(bad), .vary = vary };
