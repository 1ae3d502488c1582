/* SPDX-License-Identifier: Apache-2.0 */
/* grid_sample against torch.nn.functional.grid_sample, align_corners false. */
#include "tests/ops/suite.h"

#include <math.h>

static lt_tensor *build(lt_tensor **in) { return lt_grid_sample(in[0], in[1]); }

/* Places between cells' centres, some of them off the map. */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    const double size[2] = { (double)c->in[0].shape.dim[3], (double)c->in[0].shape.dim[2] };

    if (input == 0)
        fill_clear_of_zero(c, input, v, n, r);
    for (int64_t i = 0; input == 1 && i < n; i++) {
        const double cell = floor(lt_rng_range(r, -3, size[i % 2] + 2)) + lt_rng_range(r, 0.1, 0.9);

        v[i] = (lt_real)((2 * cell + 1) / size[i % 2] - 1);
    }
}

static const op_case cases[] = {
    { "maps", build, .in = { S(2, 3, 5, 7), S(2, 4, 3, 2) }, .fill = fill },
    { "channels", build, .in = { S(1, 37, 6, 5), S(1, 2, 9, 2) }, .fill = fill },
    { "one", build, .in = { S(1, 1, 1, 1), S(1, 1, 1, 2) }, .fill = fill },
    { "no_places", build, .in = { S(2, 3, 5, 7), S(2, 0, 3, 2) }, .fill = fill },
    { "empty", build, .in = { S(0, 3, 5, 7), S(0, 4, 3, 2) }, .fill = fill },
    { "long", build, .in = { S(2, 35, 13, 17), S(2, 20, 11, 2) }, .fill = fill, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 3, 5, 7), S(1, 4, 3, 2) }, "grid_sample: grid is (1, 4, 3, 2), want (2, 4, 3, 2)" },
    { build, { S(2, 3, 5, 7), S(2, 4, 3, 3) }, "grid_sample: grid is (2, 4, 3, 3), want (2, 4, 3, 2)" },
    { build, { S(2, 3, 0, 7), S(2, 4, 3, 2) }, "grid_sample: the map is empty" },
    { build, { S(3, 5, 7), S(2, 4, 3, 2) }, "grid_sample: map is (3, 5, 7), want 4 dimensions" },
};

static void vary(op_case *c, lt_rng *r)
{
    vary_map(c, r);
    c->in[1].shape = LT_SHAPE(c->in[0].shape.dim[0], pick(r, 0, 5), pick(r, 1, 5), 2);
}

const op_suite grid_sample_suite = { "grid_sample", CASES(cases), BAD(bad), .vary = vary };
