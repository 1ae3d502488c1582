/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One case of an op's suite as a graph with a loss: sum(out * dout), and when inputs are read twice
 * 0.75 of their sum on top, recorded behind the op so that its backward pass finds their gradients begun.
 */
#ifndef TESTS_OPS_OP_RUN_H
#define TESTS_OPS_OP_RUN_H

#include "tests/ops/suite.h"

#include "libtensor/graph/plan.h"

#define OP_READ_AGAIN 0.75
#define OP_ALL_INPUTS ((1u << OP_INPUTS) - 1)

typedef struct {
    const op_suite *suite;
    const op_case *c;
    lt_graph *g;
    lt_plan *plan;
    lt_tensor *in[OP_INPUTS], *out[LT_MAX_OUT], *dout[LT_MAX_OUT], *loss;
    int n_out;
} op_run;

typedef struct {
    bool train, no_fusion;
    bool read_again;                /* inputs have a second reader */
    unsigned want;                  /* 1 << i: the gradient of input i is wanted, if it has one */
} op_run_opts;

/* op_run_new - record and compile; false with lt_last_error() when the op refuses */
bool op_run_new(op_run *r, const op_suite *s, const op_case *c, const op_run_opts *opts);
void op_run_free(op_run *r);

/* op_run_fill - inputs by the case's fill, douts in [-1, 1), all from the seed */
void op_run_fill(op_run *r, uint64_t seed);

/* op_run_data, op_run_grad - of an input or output; NULL where there is none */
lt_real *op_run_data(const op_run *r, const lt_tensor *t);
lt_real *op_run_grad(const op_run *r, int input);

#endif
