/* SPDX-License-Identifier: Apache-2.0 */
/* matmul against torch.matmul. */
#include "tests/ops/suite.h"

static lt_tensor *build(lt_tensor **in) { return lt_matmul(in[0], in[1]); }

static const op_case cases[] = {
    { "batch", build, .in = { S(2, 3, 7), S(2, 7, 5) } },
    { "one", build, .in = { S(1, 1), S(1, 1) } },
    { "single", build, .in = { S(17, 33), S(33, 19) } },
    { "empty_batch", build, .in = { S(0, 3, 7), S(0, 7, 5) } },
    { "empty_sum", build, .in = { S(3, 0), S(0, 5) } },
    { "long", build, .in = { S(3, 70, 129), S(3, 129, 65) }, .no_vectors = true },
};

static const op_bad_case bad[] = {
    { build, { S(2, 3), S(4, 2) }, "matmul: (2, 3) times (4, 2) is no product of matrices" },
    { build, { S(2, 3, 4), S(3, 4, 2) }, "matmul: (2, 3, 4) times (3, 4, 2) is no product of matrices" },
    { build, { S(2, 3), S(2, 3, 4) }, "matmul: (2, 3) times (2, 3, 4) is no product of matrices" },
    { build, { S(2, 3) }, "matmul: input 1 is missing" },
};

static void vary(op_case *c, lt_rng *r)
{
    const int64_t B = pick(r, 0, 3), K = pick(r, 0, 20);

    c->in[0].shape = LT_SHAPE(B, pick(r, 1, 20), K);
    c->in[1].shape = LT_SHAPE(B, K, pick(r, 1, 20));
}

const op_suite matmul_suite = { "matmul", CASES(cases), BAD(bad), .vary = vary };
