/* SPDX-License-Identifier: Apache-2.0 */
/* deformable_attention against torch.nn.functional.grid_sample, head by head. */
#include "tests/ops/suite.h"

#include <math.h>

enum { H = 5, W = 7 };

static lt_tensor *build(lt_tensor **in) { return lt_deformable_attention(in[0], in[1], in[2], in[3], 2, H, W); }
static lt_tensor *one(lt_tensor **in) { return lt_deformable_attention(in[0], in[1], in[2], in[3], 1, 1, 1); }
static lt_tensor *large(lt_tensor **in) { return lt_deformable_attention(in[0], in[1], in[2], in[3], 4, 12, 11); }
static lt_tensor *no_heads(lt_tensor **in) { return lt_deformable_attention(in[0], in[1], in[2], in[3], 0, H, W); }

/* References lie on whole numbers, offsets at least a tenth from them: samples stay clear of the kinks, on
 * the map, across its border and far away. */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    if (input == 0 || input == 2)
        fill_clear_of_zero(c, input, v, n, r);
    for (int64_t i = 0; input == 1 && i < n; i++)
        v[i] = (lt_real)(floor(lt_rng_range(r, -3, 3)) + lt_rng_range(r, 0.1, 0.9));
    for (int64_t i = 0; input == 3 && i < n; i++)
        v[i] = (lt_real)floor(lt_rng_range(r, -2, 9));
}

static const op_case cases[] = {
    { "cross", build, .in = { S(2, H * W, 12), S(2, 9, 12), S(2, 9, 6), C(9, 2) }, .fill = fill },
    { "wide", build, .in = { S(1, H * W, 38), S(1, 5, 16), S(1, 5, 8), C(5, 2) }, .fill = fill },
    { "one", one, .in = { S(1, 1, 1), S(1, 1, 2), S(1, 1, 1), C(1, 2) }, .fill = fill },
    { "no_queries", build, .in = { S(2, H * W, 6), S(2, 0, 8), S(2, 0, 4), C(0, 2) }, .fill = fill },
    { "empty_batch", build, .in = { S(0, H * W, 6), S(0, 3, 8), S(0, 3, 4), C(3, 2) }, .fill = fill },
    { "long", large, .in = { S(2, 132, 64), S(2, 150, 32), S(2, 150, 16), C(150, 2) }, .fill = fill,
      .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 34, 12), S(2, 9, 12), S(2, 9, 6), C(9, 2) },
      "deformable_attention: value has 34 cells, want those of a 5 x 7 map" },
    { build, { S(2, H * W, 13), S(2, 9, 12), S(2, 9, 6), C(9, 2) },
      "deformable_attention: 2 heads do not divide 13 channels and 6 weights" },
    { no_heads, { S(2, H * W, 12), S(2, 9, 12), S(2, 9, 6), C(9, 2) },
      "deformable_attention: 0 heads do not divide 12 channels and 6 weights" },
    { build, { S(2, H * W, 12), S(2, 9, 68), S(2, 9, 34), C(9, 2) },
      "deformable_attention: 34 weights for 2 heads, want 1 to 16 for each" },
    { build, { S(2, H * W, 12), S(2, 9, 10), S(2, 9, 6), C(9, 2) },
      "deformable_attention: offsets is (2, 9, 10), want (2, 9, 12)" },
    { build, { S(2, H * W, 12), S(2, 9, 12), S(1, 9, 6), C(9, 2) },
      "deformable_attention: weights is (1, 9, 6), want (2, 9, 6)" },
    { build, { S(2, H * W, 12), S(2, 9, 12), S(2, 9, 6), C(8, 2) },
      "deformable_attention: reference is (8, 2), want (9, 2)" },
    { build, { S(H * W, 12), S(2, 9, 12), S(2, 9, 6), C(9, 2) },
      "deformable_attention: value is (35, 12), want 3 dimensions" },
};

static void vary(op_case *c, lt_rng *r)
{
    const int64_t B = pick(r, 1, 2), T = pick(r, 0, 70), points = pick(r, 1, 5);

    c->in[0].shape = LT_SHAPE(B, H * W, 2 * pick(r, 1, 20));
    c->in[1].shape = LT_SHAPE(B, T, 4 * points);
    c->in[2].shape = LT_SHAPE(B, T, 2 * points);
    c->in[3].shape = LT_SHAPE(T, 2);
}

const op_suite deformable_attention_suite = { "deformable_attention", CASES(cases), BAD(bad), .vary = vary };
