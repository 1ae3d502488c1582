/* SPDX-License-Identifier: Apache-2.0 */
/* window_means, and a sum with them. */
#include "tests/ops/suite.h"

static lt_tensor *same(lt_tensor **in) { return lt_add(lt_window_means(in[0], 5, 4), in[1]); }
static lt_tensor *up(lt_tensor **in) { return lt_add(lt_window_means(in[0], 10, 8), in[1]); }
static lt_tensor *odd(lt_tensor **in) { return lt_add(lt_window_means(in[0], 2, 7), in[1]); }
static lt_tensor *flat(lt_tensor **in) { return lt_window_means(in[0], 1, 7); }

static const op_case cases[] = {
    { "same", same, .in = { S(2, 3, 5, 4), S(2, 3, 3, 3) } },
    { "up", up, .in = { S(2, 3, 5, 4), S(2, 3, 3, 3) } },
    { "odd", odd, .in = { S(1, 2, 6, 3), S(1, 2, 3, 3) } },
    { "empty", up, .in = { S(0, 3, 5, 4), S(0, 3, 3, 3) } },
};

static const op_bad_case bad[] = {
    { flat, { C(2, 3, 5, 4) }, "window_means: from 5 x 4 to 1 x 7: want a map, and 2 x 2 at least" },
    { same, { C(2, 3, 0, 4), S(2, 3, 3, 3) }, "window_means: from 0 x 4 to 5 x 4: want a map, and 2 x 2 at least" },
    { flat, { C(5, 4) }, "window_means: input is (5, 4), want 4 dimensions" },
};

const op_suite window_means_suite = { "window_means", CASES(cases), BAD(bad) };
