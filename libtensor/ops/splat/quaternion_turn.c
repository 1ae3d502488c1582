/* SPDX-License-Identifier: Apache-2.0 */
/* quaternion_turn: Hamilton's product of (1, d1, d2, d3) and q.
 *   q (N, 4), w first   delta (N, 4)   ->   y (N, 4)
 *   dq += conj(1, d) dy     ddelta += dy conj(q), but for its first number
 */
#include "libtensor/ops/splat/rows.h"

enum { Q, DELTA };

static lt_status infer(lt_call *c)
{
    if (lt_want_rank(c, Q, "q", 2))
        return LT_ESHAPE;
    if (lt_want_shape(c, Q, "q", LT_SHAPE(lt_dim(c->in[Q], 0), 4))
        || lt_want_shape(c, DELTA, "delta", c->in[Q]->shape))
        return LT_ESHAPE;
    c->out->shape = c->in[Q]->shape;
    return LT_OK;
}

static void forward_block(const lt_call *c, int64_t from, int64_t to)
{
    const lt_real *all = c->in[Q]->data, *delta = c->in[DELTA]->data;
    lt_real *y = c->out->data;

#pragma omp simd
    for (int64_t i = 4 * from; i < 4 * to; i += 4) {
        const lt_real *q = all + i, *d = delta + i;

        y[i] = q[0] - d[1] * q[1] - d[2] * q[2] - d[3] * q[3];
        y[i + 1] = q[1] + d[1] * q[0] + d[2] * q[3] - d[3] * q[2];
        y[i + 2] = q[2] - d[1] * q[3] + d[2] * q[0] + d[3] * q[1];
        y[i + 3] = q[3] + d[1] * q[2] - d[2] * q[1] + d[3] * q[0];
    }
}

static void q_gradient(const lt_call *c, int64_t from, int64_t to)
{
    const lt_real *delta = c->in[DELTA]->data;
    lt_real *dq = c->din[Q];

#pragma omp simd
    for (int64_t i = 4 * from; i < 4 * to; i += 4) {
        const lt_real *d = delta + i, *g = c->dout + i;

        dq[i] += g[0] + d[1] * g[1] + d[2] * g[2] + d[3] * g[3];
        dq[i + 1] += g[1] - d[1] * g[0] - d[2] * g[3] + d[3] * g[2];
        dq[i + 2] += g[2] + d[1] * g[3] - d[2] * g[0] - d[3] * g[1];
        dq[i + 3] += g[3] - d[1] * g[2] + d[2] * g[1] - d[3] * g[0];
    }
}

static void delta_gradient(const lt_call *c, int64_t from, int64_t to)
{
    const lt_real *all = c->in[Q]->data;
    lt_real *dd = c->din[DELTA];

#pragma omp simd
    for (int64_t i = 4 * from; i < 4 * to; i += 4) {
        const lt_real *q = all + i, *g = c->dout + i;

        dd[i + 1] += -g[0] * q[1] + g[1] * q[0] - g[2] * q[3] + g[3] * q[2];
        dd[i + 2] += -g[0] * q[2] + g[1] * q[3] + g[2] * q[0] - g[3] * q[1];
        dd[i + 3] += -g[0] * q[3] - g[1] * q[2] + g[2] * q[1] + g[3] * q[0];
    }
}

static void backward_block(const lt_call *c, int64_t from, int64_t to)
{
    if (c->din[Q])
        q_gradient(c, from, to);
    if (c->din[DELTA])
        delta_gradient(c, from, to);
}

static void forward(const lt_call *c)
{
    splat_by_block(c, lt_dim(c->in[Q], 0), forward_block);
}

static void backward(const lt_call *c)
{
    splat_by_block(c, lt_dim(c->in[Q], 0), backward_block);
}

static const lt_op quaternion_turn_op = {
    .name = "quaternion_turn", .keeps = LT_KEEP_IN(Q) | LT_KEEP_IN(DELTA), .infer = infer, .forward = forward,
    .backward = backward,
};

lt_tensor *(lt_quaternion_turn)(lt_tensor *q, lt_tensor *delta)
{
    return lt_apply(&quaternion_turn_op, NULL, 0, (lt_tensor *[]){ q, delta }, 2);
}
