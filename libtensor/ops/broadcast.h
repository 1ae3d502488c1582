/* SPDX-License-Identifier: Apache-2.0 */
/*
 * NumPy's broadcasting for ops of two operands: dimensions are matched from the last one, 1 stretches.
 */
#ifndef LT_OPS_BROADCAST_H
#define LT_OPS_BROADCAST_H

#include "libtensor/ops/common.h"

/* How two operands meet: an output of n_rows rows of `inner` elements, each operand's offset at a row
 * found by its strides, its step within a row 1, or 0 where it stretches. */
typedef struct {
    int rank;                       /* of the rows: the last dimension is inner */
    int64_t dim[LT_MAX_RANK], stride[2][LT_MAX_RANK];
    int64_t n_rows, inner, step[2];
} broadcast;

/* broadcast_infer - shape rule */
lt_status broadcast_infer(lt_call *c);

/* broadcast_plan - dimensions that run together are merged, so most cases have one or two */
broadcast broadcast_plan(const lt_tensor *out, const lt_tensor *a, const lt_tensor *b);

/* broadcast_row - where row i starts in operand 0 or 1 */
int64_t broadcast_row(const broadcast *b, int operand, int64_t row);

#endif
