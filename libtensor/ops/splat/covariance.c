/* SPDX-License-Identifier: Apache-2.0 */
/* splat_covariance: the upper triangle of M M^T.
 *   axes M (N, 3, 3)   ->   (N, 6): xx, xy, xz, yy, yz, zz
 *   dM += (G + G^T) M, G the gradient in the upper triangle and zeros below it
 */
#include "libtensor/ops/splat/rows.h"

static const int row_of[6] = { 0, 0, 0, 1, 1, 2 }, column_of[6] = { 0, 1, 2, 1, 2, 2 };

static lt_status infer(lt_call *c)
{
    if (lt_want_rank(c, 0, "axes", 3))
        return LT_ESHAPE;
    if (lt_want_shape(c, 0, "axes", LT_SHAPE(lt_dim(c->in[0], 0), 3, 3)))
        return LT_ESHAPE;
    c->out->shape = LT_SHAPE(lt_dim(c->in[0], 0), 6);
    return LT_OK;
}

static void forward_block(const lt_call *c, int64_t from, int64_t to)
{
    const lt_real *axes = c->in[0]->data;
    lt_real *y = c->out->data;

#pragma omp simd
    for (int64_t i = from; i < to; i++)
        for (int r = 0; r < 6; r++) {
            const lt_real *a = axes + 9 * i + 3 * row_of[r], *b = axes + 9 * i + 3 * column_of[r];

            y[6 * i + r] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        }
}

static void backward_block(const lt_call *c, int64_t from, int64_t to)
{
    const lt_real *axes = c->in[0]->data;

#pragma omp simd
    for (int64_t i = from; i < to; i++) {
        const lt_real *M = axes + 9 * i, *g = c->dout + 6 * i;
        lt_real *dM = c->din[0] + 9 * i;

        for (int k = 0; k < 3; k++) {
            dM[k] += 2 * g[0] * M[k] + g[1] * M[3 + k] + g[2] * M[6 + k];
            dM[3 + k] += g[1] * M[k] + 2 * g[3] * M[3 + k] + g[4] * M[6 + k];
            dM[6 + k] += g[2] * M[k] + g[4] * M[3 + k] + 2 * g[5] * M[6 + k];
        }
    }
}

static void forward(const lt_call *c)
{
    splat_by_block(c, lt_dim(c->in[0], 0), forward_block);
}

static void backward(const lt_call *c)
{
    if (c->din[0])
        splat_by_block(c, lt_dim(c->in[0], 0), backward_block);
}

static const lt_op splat_covariance_op = {
    .name = "splat_covariance", .keeps = LT_KEEP_IN(0), .infer = infer, .forward = forward, .backward = backward,
};

lt_tensor *(lt_splat_covariance)(lt_tensor *axes)
{
    return lt_apply(&splat_covariance_op, NULL, 0, &axes, 1);
}
