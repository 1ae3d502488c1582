/* SPDX-License-Identifier: Apache-2.0 */
/* transform_points, transform_back and blend_transforms against PyTorch. */
#include "libtensor/ops/splat/gaussians.h"
#include "tests/ops/suite.h"

static lt_tensor *points(lt_tensor **in) { return lt_transform_points(in[0], in[1]); }
static lt_tensor *back(lt_tensor **in) { return lt_transform_back(in[0], in[1]); }
static lt_tensor *blend(lt_tensor **in) { return lt_blend_transforms(in[0], in[1]); }

static const op_case points_cases[] = {
    { "each", points, .in = { S(7, 3), S(7, 3, 4) } },
    { "shared", points, .in = { S(5, 3), S(1, 3, 4) } },
    { "constant", points, .in = { S(3, 3), C(3, 3, 4) } },
    { "one", points, .in = { S(1, 3), S(1, 3, 4) } },
    { "empty", points, .in = { S(0, 3), S(1, 3, 4) } },
    { "long", points, .in = { S(700, 3), S(700, 3, 4) }, .no_vectors = true },
    { "long_shared", points, .in = { S(700, 3), S(1, 3, 4) }, .no_vectors = true },
};

static const op_bad_case points_bad[] = {
    { points, { S(7, 4), S(7, 3, 4) }, "transform_points: points is (7, 4), want (7, 3)" },
    { points, { S(7, 3), S(6, 3, 4) }, "transform_points: transforms is (6, 3, 4), want (7, 3, 4) or (1, 3, 4)" },
    { points, { S(7, 3), S(7, 12) }, "transform_points: transforms is (7, 12), want (7, 3, 4) or (1, 3, 4)" },
};

static const op_case back_cases[] = {
    { "each", back, .in = { S(7, 3), S(7, 3, 4) } },
    { "shared", back, .in = { S(5, 3), S(1, 3, 4) } },
    { "empty", back, .in = { S(0, 3), S(1, 3, 4) } },
    { "long_shared", back, .in = { S(700, 3), S(1, 3, 4) }, .no_vectors = true },
};

static const op_bad_case back_bad[] = {
    { back, { S(7), S(7, 3, 4) }, "transform_back: points is (7), want 2 dimensions" },
    { back, { S(7, 3), S(7, 4, 4) }, "transform_back: transforms is (7, 4, 4), want (7, 3, 4) or (1, 3, 4)" },
};

static const op_case blend_cases[] = {
    { "field", blend, .in = { S(9, 5), S(5, 3, 4) } },
    { "constant", blend, .in = { S(4, 2), C(2, 3, 4) } },
    { "empty", blend, .in = { S(0, 2), S(2, 3, 4) } },
};

static const op_bad_case blend_bad[] = {
    { blend, { S(9, 5), S(5, 3, 3) }, "reshape: (5, 3, 3) does not become (5, 12): another number of elements" },
};

const op_suite transform_points_suite = { "transform_points", CASES(points_cases), BAD(points_bad) };
const op_suite transform_back_suite = { "transform_back", CASES(back_cases), BAD(back_bad) };
const op_suite blend_transforms_suite = { "blend_transforms", CASES(blend_cases), BAD(blend_bad) };
