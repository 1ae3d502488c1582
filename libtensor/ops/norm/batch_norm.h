/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What batch_norm has in common with the ops that do its work: inputs 0 to 4 are batch_norm's, their attr begins with
 * norm_attr, norm_plan has asked for what is saved, and norm_count elements are a channel of the whole batch.
 * Everything else here is of one channel.
 *
 * Sums over a channel are made of one part of the batch and saved; what follows from them reads those of all parts.
 */
#ifndef LT_OPS_NORM_BATCH_NORM_H
#define LT_OPS_NORM_BATCH_NORM_H

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

/* dx = s dy + t x + u, where dy has come through the activation */
typedef struct { double s, t, u; } norm_gradient;

/* norm_before - what a node normalises with, if it is a batch norm that learns and has no residual; else NULL */
const norm_attr *norm_before(const lt_node *node);

void norm_plan(lt_call *c);
double norm_count(const lt_call *c);

/* norm_sum - the sums that a measure is made of; norm_measure_of - the measure, saved as well; without gradients it is
 * the running statistics */
void norm_sum(const lt_call *c, int64_t ch);
norm_measure norm_measure_of(const lt_call *c, int64_t ch);
const norm_measure *norm_saved(const lt_call *c, int64_t ch);
norm_line norm_line_of(const lt_call *c, int64_t ch, const norm_measure *m);

/* norm_behind - the activation, for the kernels that read x as well */
lt_behind norm_behind(const lt_call *c, int64_t ch);

/* norm_save_gradient - the sums of dy and of dy (x - mean), as the kernel grad_moments has them;
 * norm_gradient_of - what follows from them;
 * norm_collect - add this part's gradients of the parameters, and its share of the batch's statistics */
void norm_save_gradient(const lt_call *c, int64_t ch, const double sum[2]);
norm_gradient norm_gradient_of(const lt_call *c, int64_t ch);
void norm_collect(const lt_call *c, int64_t ch);

#endif
