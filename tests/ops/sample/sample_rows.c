/* SPDX-License-Identifier: Apache-2.0 */
/* sample_rows against torch.nn.functional.grid_sample. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_sample_rows(in[0], in[1], 3, 4); }

static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    if (input == 0)
        fill_clear_of_zero(c, input, v, n, r);
    for (int64_t i = 0; input == 1 && i < n; i++)
        v[i] = (lt_real)lt_rng_range(r, -1.5, 4.5);
}

static const op_case cases[] = {
    { "rows", build, .in = { S(2, 12, 5), C(2, 7, 2) }, .fill = fill },
    { "channels", build, .in = { S(1, 12, 67), C(1, 3, 2) }, .fill = fill },
    { "none", build, .in = { S(2, 12, 5), C(2, 0, 2) }, .fill = fill, .no_vectors = true },
    { "long", build, .in = { S(2, 12, 100), C(2, 301, 2) }, .fill = fill, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 13, 5), C(2, 7, 2) }, "sample_rows: the map has 13 cells, want those of 3 x 4" },
    { build, { S(2, 12, 5), C(1, 7, 2) }, "sample_rows: places are (1, 7, 2), want (2, places, 2)" },
    { build, { S(2, 12), C(1, 7, 2) }, "sample_rows: map is (2, 12), want 3 dimensions" },
};

static void vary(op_case *c, lt_rng *r)
{
    c->in[0].shape = LT_SHAPE(2, 12, pick(r, 1, 40));
    c->in[1].shape = LT_SHAPE(2, pick(r, 0, 9), 2);
}

const op_suite sample_rows_suite = { "sample_rows", CASES(cases), BAD(bad), .vary = vary };
