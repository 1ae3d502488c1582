/* SPDX-License-Identifier: Apache-2.0 */
/* nearest_rotation against the singular value decomposition in PyTorch. */
#include "libtensor/ops/splat/gaussians.h"
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_nearest_rotation(in[0], in[1]); }

/* Near the identity; the last matrix of "mirrored" is turned over. */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    fill_clear_of_zero(c, input, v, n, r);
    for (int64_t i = 0; i < n; i++)
        v[i] = (i % 9 % 4 == 0) + (lt_real)0.3 * v[i];
    for (int i = 0; input == 0 && c->in[0].shape.rank == 4 && i < 3; i++)
        v[n - 9 + i] = -v[n - 9 + i];
}

static const op_case cases[] = {
    { "some", build, .in = { S(6, 3, 3), C(6, 3, 3) }, .fill = fill },
    { "one", build, .in = { S(3, 3), C(3, 3) }, .fill = fill },
    { "mirrored", build, .in = { S(1, 2, 3, 3), C(1, 2, 3, 3) }, .fill = fill },
    { "empty", build, .in = { S(0, 3, 3), C(0, 3, 3) } },
};

static const op_bad_case bad[] = {
    { build, { S(9), C(9) }, "nearest_rotation: X is (9), want (..., 3, 3)" },
    { build, { S(2, 3, 4), C(2, 3, 4) }, "nearest_rotation: X is (2, 3, 4), want (..., 3, 3)" },
    { build, { S(2, 3, 3), C(1, 3, 3) }, "nearest_rotation: otherwise is (1, 3, 3), want (2, 3, 3)" },
};

const op_suite nearest_rotation_suite = { "nearest_rotation", CASES(cases), BAD(bad) };
