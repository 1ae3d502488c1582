/* SPDX-License-Identifier: Apache-2.0 */
/* permute against torch.permute. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in)
{
    int order[LT_MAX_RANK];

    for (int i = 0; i < in[0]->shape.rank; i++)         /* the last dimension first */
        order[i] = (i + in[0]->shape.rank - 1) % in[0]->shape.rank;
    return lt_permute(in[0], order);
}

static lt_tensor *heads(lt_tensor **in) { return lt_permute(in[0], (int[]){ 0, 2, 1, 3 }); }
static lt_tensor *as_it_is(lt_tensor **in) { return lt_permute(in[0], (int[]){ 0, 1 }); }
static lt_tensor *twice(lt_tensor **in) { return lt_permute(in[0], (int[]){ 0, 0 }); }
static lt_tensor *outside(lt_tensor **in) { return lt_permute(in[0], (int[]){ 0, 2 }); }

static const op_case cases[] = {
    { "rolled", build, .in = { S(2, 3, 5, 7) } },
    { "heads", heads, .in = { S(2, 3, 4, 5) } },
    { "same", as_it_is, .in = { S(3, 5) } },
    { "transposed", build, .in = { S(17, 33) } },
    { "row", build, .in = { S(7) } },
    { "number", build, .in = { NUMBER } },
    { "empty", build, .in = { S(3, 0) } },
    { "long", build, .in = { S(3, 101, 103) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { twice, { S(2, 3) }, "permute: order[1] = 0 is no permutation of 2 dimensions" },
    { outside, { S(2, 3) }, "permute: order[1] = 2 is no permutation of 2 dimensions" },
};

const op_suite permute_suite = { "permute", CASES(cases), BAD(bad), .vary = vary_first };
