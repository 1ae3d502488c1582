/* SPDX-License-Identifier: Apache-2.0 */
/* quaternion_turn against products of quaternions as 4 x 4 matrices in PyTorch. */
#include "libtensor/ops/splat/gaussians.h"
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_quaternion_turn(in[0], in[1]); }

static const op_case cases[] = {
    { "some", build, .in = { S(7, 4), S(7, 4) } },
    { "empty", build, .in = { S(0, 4), S(0, 4) } },
    { "long", build, .in = { S(600, 4), S(600, 4) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(7, 3), S(7, 4) }, "quaternion_turn: q is (7, 3), want (7, 4)" },
    { build, { S(7, 4), S(7, 3) }, "quaternion_turn: delta is (7, 3), want (7, 4)" },
};

const op_suite quaternion_turn_suite = { "quaternion_turn", CASES(cases), BAD(bad) };
