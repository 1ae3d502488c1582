/* SPDX-License-Identifier: Apache-2.0 */
/* one_blob against torch. */
#include "tests/ops/suite.h"

static lt_tensor *sixteen(lt_tensor **in) { return lt_one_blob(in[0], 16); }
static lt_tensor *eight(lt_tensor **in) { return lt_one_blob(in[0], 8); }
static lt_tensor *three(lt_tensor **in) { return lt_one_blob(in[0], 3); }
static lt_tensor *single(lt_tensor **in) { return lt_one_blob(in[0], 1); }

/* Between the edges of bins, where a derivative of the third order jumps: of 16 and of 3 */
static void fill(const op_case *c, int input, lt_real *v, int64_t n, lt_rng *r)
{
    (void)c, (void)input;
    for (int64_t i = 0; i < n; i++)
        v[i] = (lt_real)((lt_rng_below(r, 48) + lt_rng_range(r, 0.25, 0.75)) / 48);
}

static const op_case cases[] = {
    { "eight", eight, .in = { S(7, 3) }, .fill = fill },
    { "three", three, .in = { S(2, 3, 5) }, .fill = fill },
    { "sixteen", sixteen, .in = { C(7, 3) }, .fill = fill },        /* bends too much for differences */
    { "empty", three, .in = { S(0, 3) }, .fill = fill, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { single, { S(7, 3) }, "one_blob: 1 bins, want 2 to 1024" },
    { three, { NUMBER }, "one_blob: its input is a number, want a row at least" },
};

static void vary(op_case *c, lt_rng *r) { vary_first(c, r); }

const op_suite one_blob_suite = { "one_blob", CASES(cases), BAD(bad), .vary = vary };
