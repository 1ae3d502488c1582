/* SPDX-License-Identifier: Apache-2.0 */
/* The cross-entropy of heat maps with the maps that they should be, against torch; with a margin and without. */
#include "models/heads/heatmap_loss.h"
#include "tests/ops/suite.h"

static lt_tensor *plain(lt_tensor **in) { return heatmap_loss(in[0], in[1], 4, 5, 0, in[2]); }
static lt_tensor *margin(lt_tensor **in) { return heatmap_loss(in[0], in[1], 6, 7, 2, in[2]); }

/* Places of -0.2 to 1.2: some beyond the outermost centres. */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (input == 0 ? fill_clear_of_zero : fill_positive)(c, input, v, n, r);
    for (int64_t i = 0; input == 1 && i < n; i++)
        v[i] = (lt_real)lt_rng_range(r, -0.2, 1.2);
}

static const op_case cases[] = {
    { "plain", plain, .in = { S(3, 4, 20), C(3, 4, 2), C(3) }, .fill = fill },
    { "margin", margin, .in = { S(3, 4, 42), C(3, 4, 2), C(3) }, .fill = fill },
    { "empty", plain, .in = { S(0, 4, 20), C(0, 4, 2), C(0) }, .fill = fill, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { plain, { S(3, 4, 20), S(3, 8), C(3) }, "heatmap_target: places is (3, 8), want 3 dimensions" },
    { plain, { S(3, 4, 21), S(3, 4, 2), C(3) }, "cross_entropy: second operand is (3, 4, 20), want (3, 4, 21)" },
};

const op_suite heatmap_loss_suite = { "heatmap_loss", CASES(cases), BAD(bad) };
