/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the op does for some positions of one image, for ops that normalise on their way.
 */
#ifndef LT_OPS_NORM_L2_NORMALISE_H
#define LT_OPS_NORM_L2_NORMALISE_H

#include "libtensor/base/common.h"

enum { OP_L2_COLUMNS = 256 };           /* the most positions at once */

/* op_l2_normalise - y[c * ld_y + i] = x[c * ld_x + i] / (norm[i] + eps) for i < n <= OP_L2_COLUMNS, with norm[i] the
 * length of x's column i of so many channels; norm may be NULL, y may be x */
void op_l2_normalise(lt_real *y, int64_t ld_y, lt_real *norm, const lt_real *x, int64_t ld_x, int64_t channels,
                     int64_t n, lt_real eps);

/* op_l2_normalise_grad - dx += the gradient of x, from that of y and the norms; ld elements between channels of all */
void op_l2_normalise_grad(lt_real *dx, const lt_real *dy, const lt_real *x, const lt_real *norm, int64_t ld,
                          int64_t channels, int64_t n, lt_real eps);

#endif
