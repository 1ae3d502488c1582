/* SPDX-License-Identifier: Apache-2.0 */
/* conv_transpose2d against torch.nn.functional.conv_transpose2d. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_conv_transpose2d(in[0], in[1], in[2], 1, 0); }
static lt_tensor *padded(lt_tensor **in) { return lt_conv_transpose2d(in[0], in[1], in[2], 2, 1); }
static lt_tensor *twice(lt_tensor **in) { return lt_conv_transpose2d(in[0], in[1], in[2], 2, 0); }
static lt_tensor *same(lt_tensor **in) { return lt_conv_transpose2d(in[0], in[1], in[2], 1, 1); }
static lt_tensor *no_stride(lt_tensor **in) { return lt_conv_transpose2d(in[0], in[1], in[2], 0, 0); }

static const op_case cases[] = {
    { "plain", build, .in = { S(2, 3, 5, 4), S(3, 4, 3, 3), S(4) } },
    { "up1", padded, .in = { S(2, 6, 4, 4), S(6, 5, 3, 3), S(5) } },
    { "up2", padded, .in = { S(1, 4, 7, 6), S(4, 3, 4, 4), S(3) } },
    { "up3", twice, .in = { S(1, 3, 5, 6), S(3, 2, 6, 6), S(2) } },
    { "no_bias", padded, .in = { S(1, 2, 6, 5), S(2, 3, 4, 4) } },
    { "gaps", twice, .in = { S(1, 2, 3, 4), S(2, 3, 1, 1), S(3) } },
    { "oblong", build, .in = { S(1, 2, 3, 4), S(2, 3, 1, 5), S(3) } },
    { "one", build, .in = { S(1, 1, 1, 1), S(1, 1, 1, 1), S(1) } },
    { "empty", padded, .in = { S(0, 2, 6, 5), S(2, 3, 4, 4), S(3) } },
    { "long", padded, .in = { S(3, 37, 9, 11), S(37, 29, 4, 4), S(29) }, .no_vectors = true },
    { "winograd", same, .in = { S(1, 32, 12, 13), S(32, 32, 3, 3), S(32) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(1, 5, 6, 6), S(3, 2, 3, 3), S(2) }, "conv_transpose2d: input has 5 channels, weight wants 3" },
    { build, { S(1, 3, 6, 6), S(3, 2, 3, 3), S(3) }, "conv_transpose2d: bias is (3), want (2)" },
    { build, { S(3, 6, 6), S(3, 2, 3, 3), S(2) }, "conv_transpose2d: input is (3, 6, 6), want 4 dimensions" },
    { padded, { S(1, 3, 1, 6), S(3, 2, 2, 3) },
      "conv_transpose2d: nothing is left of the map: it would be 0 x 11" },
    { build, { S(1, 3, 0, 6), S(3, 2, 3, 3) },
      "conv_transpose2d: nothing is left of the map: it would be 2 x 8" },
    { no_stride, { S(1, 3, 6, 6), S(3, 2, 3, 3) }, "conv_transpose2d: stride 0, pad 0: want 1, 0 or more" },
    { build, { S(1, 1, 4, 4), S(1, 1, 33, 32) },
      "conv_transpose2d: a 33 x 32 window: want 1 to 1024 elements" },
    { build, { S(1, 3, 6, 6) }, "conv_transpose2d: input 1 is missing" },
};

static void vary(op_case *c, lt_rng *r)
{
    const int64_t channels = pick(r, 1, 6), out = pick(r, 1, 6), k = pick(r, 3, 6);

    c->build = lt_rng_below(r, 2) ? padded : twice;
    c->in[0].shape = LT_SHAPE(pick(r, 0, 3), channels, pick(r, 1, 9), pick(r, 1, 9));
    c->in[1].shape = LT_SHAPE(channels, out, k, k);
    c->in[2].shape = LT_SHAPE(out);
}

const op_suite conv_transpose2d_suite = { "conv_transpose2d", CASES(cases), BAD(bad), .vary = vary };
