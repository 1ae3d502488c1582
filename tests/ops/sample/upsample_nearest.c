/* SPDX-License-Identifier: Apache-2.0 */
/* upsample_nearest against torch.nn.functional.interpolate. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_upsample_nearest(in[0], 2); }
static lt_tensor *triple(lt_tensor **in) { return lt_upsample_nearest(in[0], 3); }
static lt_tensor *once(lt_tensor **in) { return lt_upsample_nearest(in[0], 1); }
static lt_tensor *never(lt_tensor **in) { return lt_upsample_nearest(in[0], 0); }

static const op_case cases[] = {
    { "twice", build, .in = { S(2, 3, 5, 7) } },
    { "triple", triple, .in = { S(1, 2, 3, 1) } },
    { "once", once, .in = { S(1, 2, 3, 4) } },
    { "empty", build, .in = { S(1, 3, 0, 7) } },
    { "long", build, .in = { S(3, 17, 23, 19) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(3, 5) }, "upsample_nearest: input is (3, 5), want 4 dimensions" },
    { never, { S(1, 3, 2, 5) }, "upsample_nearest: factor is 0, want at least 1" },
    { build, { S(0, 3, 1, 4611686018427387904) },
      "upsample_nearest: 2 times 1 x 4611686018427387904 cells are too many" },
};

const op_suite upsample_nearest_suite = { "upsample_nearest", CASES(cases), BAD(bad), .vary = vary_map };
