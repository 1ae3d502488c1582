/* SPDX-License-Identifier: Apache-2.0 */
/* reshape: a view; its gradient is the same memory. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_reshape(in[0], LT_SHAPE(lt_numel(in[0]))); }
static lt_tensor *chain(lt_tensor **in) { return lt_reshape(lt_reshape(in[0], LT_SHAPE(6, 4)), LT_SHAPE(2, 12)); }
static lt_tensor *more(lt_tensor **in) { return lt_reshape(in[0], LT_SHAPE(3, 3)); }
static lt_tensor *deep(lt_tensor **in) { return lt_reshape(in[0], (lt_shape){ .rank = 7, .dim = { 1, 2, 4 } }); }
static lt_tensor *negative(lt_tensor **in) { return lt_reshape(in[0], LT_SHAPE(-2, -4)); }

static const op_case cases[] = {
    { "flat", build, .in = { S(2, 3, 5) } },
    { "chain", chain, .in = { S(4, 6) } },
    { "number", build, .in = { NUMBER } },
    { "empty", build, .in = { S(0, 7) } },
};

static const op_bad_case bad[] = {
    { more, { S(2, 4) }, "reshape: (2, 4) does not become (3, 3): another number of elements" },
    { deep, { S(2, 4) }, "reshape: (2, 4) does not become (of 7 dimensions): want at most 6" },
    { negative, { S(2, 4) }, "reshape: its result would be (-2, -4), which no memory holds" },
};

const op_suite reshape_suite = { "reshape", CASES(cases), BAD(bad), .vary = vary_first };
