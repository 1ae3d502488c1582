/* SPDX-License-Identifier: Apache-2.0 */
/* mse_loss against torch, with and without weights of the samples. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_mse_loss(in[0], in[1], in[2]); }

/* Differences of at least 0.1; weights of 0.5 and more, the second 0. */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (input == 2 ? fill_positive : fill_clear_of_zero)(c, input, v, n, r);
    for (int64_t i = 0; input == 1 && i < n; i++)
        v[i] += v[i] > 0 ? 2 : -2;
    if (input == 2 && n > 1)
        v[1] = 0;
}

static const op_case cases[] = {
    { "weighed", build, .in = { S(3, 4, 5), S(3, 4, 5), C(3) }, .fill = fill },
    { "plain", build, .in = { S(3, 67), S(3, 67) }, .fill = fill },
    { "target", build, .in = { S(2, 5), C(2, 5), C(2) }, .fill = fill },
    { "number", build, .in = { NUMBER, NUMBER }, .fill = fill },
    { "empty", build, .in = { S(0, 4), S(0, 4) }, .fill = fill, .no_vectors = true },
    { "long", build, .in = { S(37, 999), S(37, 999), C(37) }, .fill = fill, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 3), S(3, 2) }, "mse_loss: second operand is (3, 2), want (2, 3)" },
    { build, { S(2, 3), S(2, 3), C(3) }, "mse_loss: weight is (3), want (2)" },
    { build, { S(2, 3) }, "mse_loss: input 1 is missing" },
};

static void vary(op_case *c, lt_rng *r)
{
    vary_first(c, r);
    c->in[1].shape = c->in[0].shape;
    c->in[2].shape = LT_SHAPE(c->in[0].shape.dim[0]);
}

const op_suite mse_loss_suite = { "mse_loss", CASES(cases), BAD(bad), .vary = vary };
