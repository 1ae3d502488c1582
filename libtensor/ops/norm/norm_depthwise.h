/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A depthwise convolution that does the batch norm and the activation before it, in plans with gradients.
 */
#ifndef LT_OPS_NORM_NORM_DEPTHWISE_H
#define LT_OPS_NORM_NORM_DEPTHWISE_H

#include "libtensor/kernels/conv/conv.h"
#include "libtensor/ops/common.h"

/* op_norm_depthwise - let node, a convolution p without a bias whose weights are w, do the work of `before` as well;
 * false if it stays as it is: `before` is no batch norm that learns, or has a residual, or p is not depthwise with
 * large maps */
bool op_norm_depthwise(lt_node *node, const lt_node *before, lt_tensor *w, const lt_conv2d_params *p);

#endif
