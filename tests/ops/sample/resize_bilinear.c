/* SPDX-License-Identifier: Apache-2.0 */
/* resize_bilinear against torch.nn.functional.interpolate, align_corners false. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_resize_bilinear(in[0], 7, 11); }
static lt_tensor *down(lt_tensor **in) { return lt_resize_bilinear(in[0], 3, 2); }
static lt_tensor *to_one(lt_tensor **in) { return lt_resize_bilinear(in[0], 1, 1); }
static lt_tensor *to_none(lt_tensor **in) { return lt_resize_bilinear(in[0], 0, 4); }

static const op_case cases[] = {
    { "up", build, .in = { S(2, 3, 5, 4) } },
    { "down", down, .in = { S(1, 2, 8, 7) } },
    { "same", build, .in = { S(1, 1, 7, 11) } },
    { "from_one", build, .in = { S(1, 2, 1, 1) } },
    { "to_one", to_one, .in = { S(1, 2, 4, 3) } },
    { "empty", build, .in = { S(0, 3, 5, 4) } },
    { "long", build, .in = { S(3, 37, 23, 19) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(3, 5) }, "resize_bilinear: input is (3, 5), want 4 dimensions" },
    { to_none, { S(1, 3, 2, 5) }, "resize_bilinear: from 2 x 5 to 0 x 4: a map may not be empty" },
    { build, { S(1, 3, 0, 5) }, "resize_bilinear: from 0 x 5 to 7 x 11: a map may not be empty" },
};

const op_suite resize_bilinear_suite = { "resize_bilinear", CASES(cases), BAD(bad), .vary = vary_map };
