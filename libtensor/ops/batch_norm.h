/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What batch_norm shares with the ops that do its work: inputs 0 to 4 are batch_norm's, their attr begins with
 * norm_attr, and saved[0] is a norm_measure for each channel. Everything here is of one channel.
 */
#ifndef LT_OPS_BATCH_NORM_H
#define LT_OPS_BATCH_NORM_H

#include "libtensor/ops/common.h"

enum { NORM_X, NORM_WEIGHT, NORM_BIAS, NORM_MEAN, NORM_VAR, NORM_INPUTS };

typedef struct {
    double eps;
    lt_act act;                         /* leaky relu, silu, or none */
} norm_attr;

/* What its batch measured, or the running statistics */
typedef struct {
    double mean, var, rstd;
} norm_measure;

/* n weight + bias as scale x + shift */
typedef struct { lt_real scale, shift; } norm_line;

/* Of parameters, and dx = s dy + t x + u where dy has come through the activation */
typedef struct { double dweight, dbias, s, t, u; } norm_gradient;

/* norm_before - what a node normalises with, if it is a batch norm that learns and has no residual; else NULL */
const norm_attr *norm_before(const lt_node *node);

norm_measure norm_measure_channel(const lt_call *c, int64_t ch);
norm_line norm_line_of(const lt_call *c, int64_t ch, const norm_measure *m);

/* norm_behind - the activation, for the kernels that read x as well */
lt_behind norm_behind(const lt_call *c, int64_t ch);

/* norm_gradient_of - from the sums of dy and of dy (x - mean), as the kernel grad_moments has them;
 * norm_collect - add the gradients of the parameters, and the batch's statistics */
norm_gradient norm_gradient_of(const lt_call *c, int64_t ch, const double sum[2]);
void norm_collect(const lt_call *c, int64_t ch, const norm_gradient *g);

#endif
