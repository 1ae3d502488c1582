/* SPDX-License-Identifier: Apache-2.0 */
/* conv2d against torch.nn.functional.conv2d. */
#include "tests/ops/suite.h"

static lt_tensor *with(lt_tensor **in, lt_conv_opts o) { return lt_conv2d(in[0], in[1], in[2], &o); }
static lt_tensor *build(lt_tensor **in) { return lt_conv2d(in[0], in[1], in[2], NULL); }
static lt_tensor *padded(lt_tensor **in) { return with(in, (lt_conv_opts){ .pad = 1 }); }
static lt_tensor *strided(lt_tensor **in) { return with(in, (lt_conv_opts){ .stride = 2, .pad = 1 }); }
static lt_tensor *stem(lt_tensor **in) { return with(in, (lt_conv_opts){ .stride = 2, .pad = 3 }); }
static lt_tensor *skip(lt_tensor **in) { return with(in, (lt_conv_opts){ .stride = 2 }); }
static lt_tensor *dilated(lt_tensor **in) { return with(in, (lt_conv_opts){ .pad = 2, .dilation = 2 }); }
static lt_tensor *grouped(lt_tensor **in) { return with(in, (lt_conv_opts){ .pad = 1, .groups = 2 }); }
static lt_tensor *depthwise(lt_tensor **in)
{
    return with(in, (lt_conv_opts){ .pad = 1, .groups = (int)lt_dim(in[0], 1) });
}
static lt_tensor *only_h(lt_tensor **in) { return with(in, (lt_conv_opts){ .stride = 2, .pad = 4, .only_h = true }); }
static lt_tensor *only_h_apart(lt_tensor **in)
{
    return with(in, (lt_conv_opts){ .pad = 2, .dilation = 2, .only_h = true });
}
static lt_tensor *only_h_same(lt_tensor **in) { return with(in, (lt_conv_opts){ .pad = 4, .only_h = true }); }
static lt_tensor *backward_stride(lt_tensor **in) { return with(in, (lt_conv_opts){ .stride = -1 }); }

static const op_case cases[] = {
    { "plain", build, .in = { S(2, 3, 5, 7), S(4, 3, 3, 3), S(4) } },
    { "pointwise", build, .in = { S(2, 5, 4, 9), S(3, 5, 1, 1), S(3) } },
    { "no_bias", padded, .in = { S(1, 2, 6, 5), S(3, 2, 3, 3) } },
    { "strided", strided, .in = { S(2, 3, 9, 8), S(4, 3, 3, 3), S(4) } },
    { "stem", stem, .in = { S(1, 3, 13, 17), S(2, 3, 7, 7) } },
    { "skip", skip, .in = { S(1, 4, 7, 9), S(5, 4, 1, 1) } },
    { "dilated", dilated, .in = { S(1, 2, 7, 9), S(3, 2, 3, 3), S(3) } },
    { "grouped", grouped, .in = { S(2, 4, 5, 6), S(6, 2, 3, 3), S(6) } },
    { "depthwise", depthwise, .in = { S(2, 5, 6, 19), S(5, 1, 3, 3), S(5) } },
    { "oblong", build, .in = { S(1, 2, 6, 8), S(3, 2, 1, 5), S(3) } },
    { "one", build, .in = { S(1, 1, 1, 1), S(1, 1, 1, 1), S(1) } },
    { "empty", padded, .in = { S(0, 2, 6, 5), S(3, 2, 3, 3), S(3) } },
    { "only_h", only_h, .in = { S(2, 3, 15, 7), S(4, 3, 9, 1), S(4) } },
    { "only_h_apart", only_h_apart, .in = { S(1, 3, 8, 5), S(2, 3, 3, 1) } },
    { "only_h_long", only_h, .in = { S(2, 32, 15, 65), S(33, 32, 9, 1), S(33) }, .no_vectors = true },
    { "only_h_same", only_h_same, .in = { S(1, 64, 8, 65), S(32, 64, 9, 1), S(32) }, .no_vectors = true },
    { "long", padded, .in = { S(2, 17, 23, 29), S(19, 17, 3, 3), S(19) }, .no_vectors = true },
    { "winograd", padded, .in = { S(1, 32, 12, 13), S(32, 32, 3, 3), S(32) }, .no_vectors = true },
    { "long_pointwise", build, .in = { S(3, 33, 21, 17), S(40, 33, 1, 1), S(40) }, .no_vectors = true },
    { "long_depthwise", depthwise, .in = { S(2, 9, 31, 33), S(9, 1, 3, 3), S(9) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(1, 5, 6, 6), S(2, 3, 3, 3), S(2) }, "conv2d: input has 5 channels, weight wants 3" },
    { grouped, { S(1, 6, 6, 6), S(3, 3, 3, 3), S(3) }, "conv2d: 2 groups do not divide 3 output channels" },
    { build, { S(1, 3, 2, 6), S(2, 3, 3, 3), S(2) }, "conv2d: a 3 x 3 window does not fit a 2 x 6 map" },
    { strided, { S(1, 3, 6, 2), S(2, 3, 5, 5), S(2) }, "conv2d: a 5 x 5 window does not fit a 6 x 2 map" },
    { build, { S(1, 3, 6, 6), S(2, 3, 3, 4294967297), S(2) },
      "conv2d: a 3 x 4294967297 window: want 1 to 1024 elements" },
    { build, { S(1, 3, 6, 6), S(2, 3, 3, 3), S(3) }, "conv2d: bias is (3), want (2)" },
    { build, { S(3, 6, 6), S(2, 3, 3, 3), S(2) }, "conv2d: input is (3, 6, 6), want 4 dimensions" },
    { backward_stride, { S(1, 3, 6, 6), S(2, 3, 3, 3) },
      "conv2d: stride -1, pad 0, dilation 1, groups 1: want 1, 0, 1, 1 or more" },
    { build, { S(1, 1, 40, 40), S(1, 1, 33, 32) },
      "conv2d: a 33 x 32 window: want 1 to 1024 elements" },
    { build, { S(1, 3, 6, 6) }, "conv2d: input 1 is missing" },
    { build, { S(1, 1, 9, 0), S(2, 1, 3, 3), S(2) },
      "conv2d: input is (1, 1, 9, 0), weight is (2, 1, 3, 3): want channels, maps and windows that are not empty" },
    { build, { S(1, 1, 9, 9), S(2, 1, 0, 3), S(2) },
      "conv2d: input is (1, 1, 9, 9), weight is (2, 1, 0, 3): want channels, maps and windows that are not empty" },
    { build, { S(1, 0, 9, 9), S(2, 0, 3, 3), S(2) },
      "conv2d: input is (1, 0, 9, 9), weight is (2, 0, 3, 3): want channels, maps and windows that are not empty" },
};

static void vary(op_case *c, lt_rng *r)
{
    const int64_t channels = pick(r, 1, 6), out = pick(r, 1, 6), k = pick(r, 1, 3);

    c->build = k == 1 ? skip : lt_rng_below(r, 2) ? strided : padded;
    c->in[0].shape = LT_SHAPE(pick(r, 0, 3), channels, pick(r, 3, 9), pick(r, 3, 19));
    c->in[1].shape = LT_SHAPE(out, channels, k, k);
    c->in[2].shape = LT_SHAPE(out);
}

const op_suite conv2d_suite = { "conv2d", CASES(cases), BAD(bad), .vary = vary };
