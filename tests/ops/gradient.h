/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An op's gradient against central differences, in the double build.
 */
#ifndef TESTS_OPS_GRADIENT_H
#define TESTS_OPS_GRADIENT_H

#include "tests/ops/suite.h"

/* The bound that palmar-gradcheck holds every op to. */
#define GRADIENT_BOUND 1e-6

typedef struct {
    double worst;                   /* largest relative error, of the signed difference */
    char where[96];                 /* "in1[5]: 0.25, differences say 0.5" */
    long probes;
} gradient_report;

/**
 * gradient_check - all of one case: inputs one element at a time, all of them along a direction, and
 * the gradient of inputs with one reader against that of inputs with two
 *
 * Takes the worst into *out, which starts zeroed. Large inputs are probed at random places.
 * False with lt_last_error() when the op refuses.
 */
bool gradient_check(const op_suite *s, const op_case *c, uint64_t seed, gradient_report *out);

/* gradient_check_op - every case of the suite, and `shapes` random ones */
bool gradient_check_op(const op_suite *s, int shapes, gradient_report *out);

#endif
