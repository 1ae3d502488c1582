/* SPDX-License-Identifier: Apache-2.0 */
/* Columns of channels made one long, against the formula in torch. */
#include "tests/ops/suite.h"

static lt_tensor *lpips(lt_tensor **in) { return lt_l2_normalise(in[0], 1e-10); }
static lt_tensor *large(lt_tensor **in) { return lt_l2_normalise(in[0], 0.5); }
static lt_tensor *none(lt_tensor **in) { return lt_l2_normalise(in[0], 0); }

static const op_case cases[] = {
    { "map", lpips, .in = { S(2, 3, 5, 7) } },
    { "rows", large, .in = { S(3, 67) } },
    { "wide", large, .in = { S(2, 5, 263) } },              /* two pieces, the last one short */
    { "one", large, .in = { S(1, 1) } },
    { "empty", lpips, .in = { S(0, 3, 2) } },
};

static const op_bad_case bad[] = {
    { lpips, { S(3) }, "l2_normalise: its input has 1 dimensions, want a batch of channels at least" },
    { none, { S(3, 4) }, "l2_normalise: eps is 0, want a number above 0" },
};

const op_suite l2_normalise_suite = { "l2_normalise", CASES(cases), BAD(bad), .vary = vary_map };
