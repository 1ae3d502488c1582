/* SPDX-License-Identifier: Apache-2.0 */
/* Points as the kernels want them: planes of x, y and z. */
#ifndef LT_OPS_POINTS_PLANES_H
#define LT_OPS_POINTS_PLANES_H

#include "libtensor/ops/common.h"

/* op_plane_length - elements of a plane of n points: ld of the kernels */
static inline int64_t op_plane_length(int64_t n)
{
    return lt_ceil_div(n, LT_POINTS) * LT_POINTS;
}

/* op_planes_work - bytes for the planes of B sets of n points;  op_planes - make those of in[i] (B, n, 3) at `planes`.
 * Points that are not finite are NaN there, and so are no points. */
size_t op_planes_work(int64_t B, int64_t n);
void op_planes(const lt_call *c, int i, lt_real *planes);

/* op_want_points - of in[i]: (B, N, 3) with N in 1 .. INT32_MAX */
lt_status op_want_points(lt_call *c, int i, const char *what);

#endif
