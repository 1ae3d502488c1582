/* SPDX-License-Identifier: Apache-2.0 */
/* nearest: distances against torch.cdist, and which points they are of by gathering these. */
#include "tests/ops/suite.h"

static lt_tensor *distance(lt_tensor **in) { return lt_scale(lt_nearest(in[0], in[1]), 1); }
static lt_tensor *which(lt_tensor **in) { return lt_gather(in[1], lt_result(lt_nearest(in[0], in[1]), 1)); }

/* Others near the places of a lattice, each point near one of them: no two are almost equally near. */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    const int64_t M = c->in[1].shape.dim[1], N = c->in[input].shape.dim[1];

    for (int64_t i = 0; i < n; i++) {
        const int64_t place = i / 3 % N % M;

        v[i] = (lt_real)((double)(place >> 2 * (i % 3) & (i % 3 < 2 ? 3 : ~0))
                         + (input ? lt_rng_range(r, -0.05, 0.05) : lt_rng_range(r, 0.15, 0.3)));
    }
}

static const op_case cases[] = {
    { "distance", distance, .in = { S(2, 7, 3), S(2, 37, 3) }, .fill = fill },
    { "to_constants", distance, .in = { S(1, 5, 3), C(1, 16, 3) }, .fill = fill },
    { "of_constants", distance, .in = { C(1, 40, 3), S(1, 3, 3) }, .fill = fill },
    { "which", which, .in = { C(2, 9, 3), S(2, 19, 3) }, .fill = fill },
    { "one", distance, .in = { S(1, 1, 3), S(1, 1, 3) }, .fill = fill },
    { "long", distance, .in = { S(3, 200, 3), S(3, 60, 3) }, .fill = fill, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { distance, { S(2, 5, 3), S(1, 5, 3) }, "nearest: points of 2 sets, others of 1" },
    { distance, { S(2, 5), S(2, 5, 3) }, "nearest: points is (2, 5), want 3 dimensions" },
};

static void vary(op_case *c, lt_rng *r)
{
    c->in[0].shape = LT_SHAPE(2, pick(r, 1, 9), 3);
    c->in[1].shape = LT_SHAPE(2, pick(r, 1, 40), 3);
}

const op_suite nearest_suite = { "nearest", CASES(cases), BAD(bad), .vary = vary };
