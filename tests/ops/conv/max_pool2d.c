/* SPDX-License-Identifier: Apache-2.0 */
/* max_pool2d against torch.nn.functional.max_pool2d. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_max_pool2d(in[0], 3, 2, 1, false); }
static lt_tensor *halves(lt_tensor **in) { return lt_max_pool2d(in[0], 2, 2, 0, false); }
static lt_tensor *ceiled(lt_tensor **in) { return lt_max_pool2d(in[0], 2, 2, 0, true); }
static lt_tensor *ceiled_pad(lt_tensor **in) { return lt_max_pool2d(in[0], 3, 2, 1, true); }
static lt_tensor *apart(lt_tensor **in) { return lt_max_pool2d(in[0], 1, 3, 0, true); }
static lt_tensor *too_padded(lt_tensor **in) { return lt_max_pool2d(in[0], 3, 1, 2, false); }
static lt_tensor *no_stride(lt_tensor **in) { return lt_max_pool2d(in[0], 2, 0, 0, false); }

static const op_case cases[] = {
    { "stem", build, .in = { S(2, 3, 9, 8) }, .fill = fill_apart },
    { "halves", halves, .in = { S(1, 2, 5, 7) }, .fill = fill_apart },
    { "ceiled", ceiled, .in = { S(1, 2, 5, 7) }, .fill = fill_apart },
    { "ceiled_pad", ceiled_pad, .in = { S(1, 2, 6, 7) }, .fill = fill_apart },
    { "apart", apart, .in = { S(1, 2, 7, 8) }, .fill = fill_apart },
    { "one", build, .in = { S(1, 1, 1, 1) }, .fill = fill_apart },
    { "empty", build, .in = { S(0, 3, 9, 8) }, .fill = fill_apart },
    { "long", build, .in = { S(2, 7, 41, 43) }, .fill = fill_apart, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { too_padded, { S(1, 1, 4, 4) },
      "max_pool2d: window 3, stride 1, pad 2: want k >= 1, stride >= 1, 0 <= pad <= k / 2" },
    { no_stride, { S(1, 1, 4, 4) },
      "max_pool2d: window 2, stride 0, pad 0: want k >= 1, stride >= 1, 0 <= pad <= k / 2" },
    { halves, { S(1, 1, 1, 4) }, "max_pool2d: a 2 x 2 window does not fit a 1 x 4 map" },
    { halves, { S(4, 4) }, "max_pool2d: input is (4, 4), want 4 dimensions" },
    { build, { S(1, 1, 4, 0) }, "max_pool2d: a 3 x 3 window does not fit a 4 x 0 map" },
    { build, { S(1, 1, 0, 64) }, "max_pool2d: a 3 x 3 window does not fit a 0 x 64 map" },
    { ceiled, { S(1, 1, 0, 0) }, "max_pool2d: a 2 x 2 window does not fit a 0 x 0 map" },
};

const op_suite max_pool2d_suite = { "max_pool2d", CASES(cases), BAD(bad), .vary = vary_map };
