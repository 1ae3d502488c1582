/* SPDX-License-Identifier: Apache-2.0 */
/* The cross-entropy of volumes with those that they should be, against torch; of some joints nothing is known. */
#include "models/body/volume_loss.h"
#include "tests/ops/suite.h"

static lt_tensor *volume(lt_tensor **in) { return volume_loss(in[0], in[1], in[2], (volume_size){ 2, 4, 5 }, in[3]); }
static lt_tensor *flat(lt_tensor **in) { return volume_loss(in[0], in[1], in[2], (volume_size){ 1, 3, 7 }, in[3]); }

/* Places of -1 to 5: some beyond the outermost middles. */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (input == 0 ? fill_clear_of_zero : fill_positive)(c, input, v, n, r);
    for (int64_t i = 0; input == 1 && i < n; i++)
        v[i] = (lt_real)lt_rng_range(r, -1, 5);
    for (int64_t i = 0; input == 2 && i < n; i++)
        v[i] = (lt_real)(i % 3 > 0);
}

static const op_case cases[] = {
    { "volume", volume, .in = { S(3, 4, 40), C(3, 4, 3), C(3, 4), C(3) }, .fill = fill },
    { "flat", flat, .in = { S(3, 4, 21), C(3, 4, 3), C(3, 4), C(3) }, .fill = fill },
    { "empty", volume, .in = { S(0, 4, 40), C(0, 4, 3), C(0, 4), C(0) }, .fill = fill, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { volume, { S(3, 4, 40), S(3, 12), S(3, 4), S(3) }, "volume_target: places is (3, 12), want 3 dimensions" },
    { volume, { S(3, 4, 40), S(3, 4, 2), S(3, 4), S(3) }, "volume_target: a place has 2 numbers, want 3" },
    { volume, { S(3, 4, 40), S(3, 4, 3), S(3, 5), S(3) }, "volume_target: known is (3, 5), want (3, 4)" },
    { volume, { S(3, 4, 41), S(3, 4, 3), S(3, 4), S(3) },
      "cross_entropy: second operand is (3, 4, 40), want (3, 4, 41)" },
};

const op_suite volume_loss_suite = { "volume_loss", CASES(cases), BAD(bad) };
