/* SPDX-License-Identifier: Apache-2.0 */
/* leaky_relu and relu against torch, on both sides of the kink and at it. */
#include "tests/ops/suite.h"

#include <math.h>

static lt_tensor *build(lt_tensor **in) { return lt_leaky_relu(in[0], 0.1); }
static lt_tensor *relu(lt_tensor **in) { return lt_relu(in[0]); }
static lt_tensor *steep(lt_tensor **in) { return lt_leaky_relu(in[0], 3); }
static lt_tensor *negative(lt_tensor **in) { return lt_leaky_relu(in[0], -0.1); }
static lt_tensor *infinite(lt_tensor **in) { return lt_leaky_relu(in[0], INFINITY); }

static const op_case cases[] = {
    { "one", build, .in = { S(1) } },
    { "map", build, .in = { S(2, 3, 5, 7) } },
    { "relu", relu, .in = { S(3, 67) } },
    { "steep", steep, .in = { S(19) } },
    { "empty", build, .in = { S(0, 7) } },
    { "long", build, .in = { S(40001) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { negative, { S(2) }, "leaky_relu: slope is -0.1, want a finite number that is not negative" },
    { infinite, { S(2) }, "leaky_relu: slope is inf, want a finite number that is not negative" },
};

const op_suite leaky_relu_suite = { "leaky_relu", CASES(cases), BAD(bad), .vary = vary_first };
