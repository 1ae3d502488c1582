/* SPDX-License-Identifier: Apache-2.0 */
/* splat_axes and splat_covariance against PyTorch. */
#include "libtensor/ops/splat/gaussians.h"
#include "tests/ops/suite.h"

static lt_tensor *axes(lt_tensor **in) { return lt_splat_axes(in[0], in[1], in[2]); }
static lt_tensor *covariance(lt_tensor **in) { return lt_splat_covariance(in[0]); }

static const op_case axes_cases[] = {
    { "each", axes, .in = { S(7, 3), S(7, 4), S(7, 3, 4) } },
    { "shared", axes, .in = { S(5, 3), S(5, 4), S(1, 3, 4) } },
    { "constant", axes, .in = { S(3, 3), S(3, 4), C(3, 3, 4) } },
    { "empty", axes, .in = { S(0, 3), S(0, 4), S(1, 3, 4) } },
    { "long", axes, .in = { S(600, 3), S(600, 4), S(600, 3, 4) }, .no_vectors = true },
    { "long_shared", axes, .in = { S(600, 3), S(600, 4), S(1, 3, 4) }, .no_vectors = true },
};

static const op_bad_case axes_bad[] = {
    { axes, { S(7, 2), S(7, 4), S(7, 3, 4) }, "splat_axes: log_scale is (7, 2), want (7, 3)" },
    { axes, { S(7, 3), S(6, 4), S(7, 3, 4) }, "splat_axes: quaternion is (6, 4), want (7, 4)" },
    { axes, { S(7, 3), S(7, 4), S(3, 4) }, "splat_axes: transforms is (3, 4), want (7, 3, 4) or (1, 3, 4)" },
};

static const op_case covariance_cases[] = {
    { "some", covariance, .in = { S(7, 3, 3) } },
    { "empty", covariance, .in = { S(0, 3, 3) } },
    { "long", covariance, .in = { S(600, 3, 3) }, .no_vectors = true },
};

static const op_bad_case covariance_bad[] = {
    { covariance, { S(7, 9) }, "splat_covariance: axes is (7, 9), want 3 dimensions" },
    { covariance, { S(7, 3, 4) }, "splat_covariance: axes is (7, 3, 4), want (7, 3, 3)" },
};

const op_suite splat_axes_suite = { "splat_axes", CASES(axes_cases), BAD(axes_bad) };
const op_suite splat_covariance_suite = { "splat_covariance", CASES(covariance_cases), BAD(covariance_bad) };
