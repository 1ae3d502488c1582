/* SPDX-License-Identifier: Apache-2.0 */
/* aggregate against products with whole matrices in torch. */
#include "tests/ops/suite.h"

/* As in scripts/vectors/ops.py */
static const lt_link list[] = {
    { 0, 0, 0, 0.5 }, { 1, 3, 0, 0.25 }, { 0, 1, 1, 1.5 }, { 1, 2, 1, -0.75 }, { 0, 2, 2, 1 }, { 1, 0, 2, 2 },
    { 1, 4, 2, 0.5 }, { 0, 3, 3, -1 }, { 0, 4, 4, 0.125 }, { 1, 2, 4, 1 },
};
static const lt_adjacency small = { 5, 2, LT_COUNT(list), list }, many = { 129, 1, LT_COUNT(list), list };

static lt_tensor *build(lt_tensor **in) { return lt_aggregate(in[0], in[1], &small); }
static lt_tensor *large(lt_tensor **in) { return lt_aggregate(in[0], in[1], &many); }

static const op_case cases[] = {
    { "few", build, .in = { S(2, 6, 3, 5), S(2, 5, 5) } },
    { "moments", build, .in = { S(1, 2, 37, 5), S(2, 5, 5) } },
    { "none", build, .in = { S(0, 6, 3, 5), S(2, 5, 5) }, .no_vectors = true },
    { "channels", build, .in = { S(2, 64, 9, 5), S(2, 5, 5) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 6, 3, 4), S(2, 5, 5) }, "aggregate: input has 4 nodes, the graph 5" },
    { build, { S(2, 7, 3, 5), S(2, 5, 5) }, "aggregate: 2 subsets do not divide 7 channels" },
    { build, { S(2, 6, 3, 5), S(5, 5) }, "aggregate: mask is (5, 5), want (2, 5, 5)" },
    { build, { S(6, 3, 5), S(2, 5, 5) }, "aggregate: input is (6, 3, 5), want 4 dimensions" },
    { large, { S(2, 6, 3, 5), S(2, 5, 5) }, "aggregate: 129 nodes in 1 subsets: want 1 to 128 in 1 to 4" },
};

static void vary(op_case *c, lt_rng *r)
{
    c->in[0].shape = LT_SHAPE(pick(r, 0, 3), 2 * pick(r, 1, 5), pick(r, 1, 40), 5);
}

const op_suite aggregate_suite = { "aggregate", CASES(cases), BAD(bad), .vary = vary };
