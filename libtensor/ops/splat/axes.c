/* SPDX-License-Identifier: Apache-2.0 */
/* splat_axes: the axes of Gaussians.                              [Kerbl et al. 2023, equation 6 and appendix A]
 *   log_scale s (N, 3)   quaternion q (N, 4)   transforms [A | t] (N, 3, 4) or (1, 3, 4)
 *   ->   M = A R(u) diag(exp s) (N, 3, 3), u = q / |q|
 *   dA += dM (R S)^T     ds_k += sum_i M_ik dM_ik     dR = A^T dM S, and through u to q
 */
#include "libtensor/ops/splat/rows.h"

enum { SCALE, QUATERNION, TRANSFORMS };

static lt_status infer(lt_call *c)
{
    int64_t N;

    if (lt_want_rank(c, SCALE, "log_scale", 2))
        return LT_ESHAPE;
    N = lt_dim(c->in[SCALE], 0);
    if (lt_want_shape(c, SCALE, "log_scale", LT_SHAPE(N, 3))
        || lt_want_shape(c, QUATERNION, "quaternion", LT_SHAPE(N, 4)) || splat_want_transforms(c, TRANSFORMS, N))
        return LT_ESHAPE;
    c->out->shape = LT_SHAPE(N, 3, 3);
    return LT_OK;
}

static int64_t count(const lt_call *c)
{
    return lt_dim(c->in[SCALE], 0);
}

static void plan(lt_call *c)
{
    c->work_bytes = splat_shared_bytes(c, TRANSFORMS, count(c));
}

/* u = q / |q|, and the length, which is 1 in place of 0: then u is 0, and R(u) no rotation */
static inline lt_real unit(const lt_real *q, lt_real u[4])
{
    const lt_real length = (lt_real)sqrt((double)(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]));
    const lt_real n = length > 0 ? length : 1;

    for (int i = 0; i < 4; i++)
        u[i] = q[i] / n;
    return n;
}

static inline void rotation(const lt_real u[4], lt_real R[9])
{
    const lt_real w = u[0], x = u[1], y = u[2], z = u[3];

    R[0] = 1 - 2 * (y * y + z * z), R[1] = 2 * (x * y - w * z), R[2] = 2 * (x * z + w * y);
    R[3] = 2 * (x * y + w * z), R[4] = 1 - 2 * (x * x + z * z), R[5] = 2 * (y * z - w * x);
    R[6] = 2 * (x * z - w * y), R[7] = 2 * (y * z + w * x), R[8] = 1 - 2 * (x * x + y * y);
}

static void forward_block(const lt_call *c, int64_t from, int64_t to)
{
    const int64_t step = splat_step(c->in[TRANSFORMS], count(c));
    const lt_real *q = c->in[QUATERNION]->data, *T = c->in[TRANSFORMS]->data;
    lt_real *M = c->out->data, scale[3 * SPLAT_ROWS];

    lt_k->exp(scale, (const lt_real *)c->in[SCALE]->data + 3 * from, (size_t)(3 * (to - from)));
#pragma omp simd
    for (int64_t i = from; i < to; i++) {
        const lt_real *A = T + i * step, *s = scale + 3 * (i - from);
        lt_real u[4], R[9];

        unit(q + 4 * i, u);
        rotation(u, R);
        for (int a = 0; a < 3; a++)
            for (int k = 0; k < 3; k++)
                M[9 * i + 3 * a + k] = (A[4 * a] * R[k] + A[4 * a + 1] * R[3 + k] + A[4 * a + 2] * R[6 + k]) * s[k];
    }
}

/* dR = A^T dM S */
static inline void rotation_gradient(const lt_real *A, const lt_real *s, const lt_real *dM, lt_real G[9])
{
    for (int b = 0; b < 3; b++)
        for (int k = 0; k < 3; k++)
            G[3 * b + k] = (A[b] * dM[k] + A[4 + b] * dM[3 + k] + A[8 + b] * dM[6 + k]) * s[k];
}

/* From G = dR to u, and through q / |q| */
static inline void quaternion_gradient(const lt_real u[4], lt_real n, const lt_real G[9], lt_real *dq)
{
    const lt_real w = u[0], x = u[1], y = u[2], z = u[3];
    const lt_real g[4] = {
        2 * (x * (G[7] - G[5]) + y * (G[2] - G[6]) + z * (G[3] - G[1])),
        2 * (y * (G[1] + G[3]) + z * (G[2] + G[6]) + w * (G[7] - G[5]) - 2 * x * (G[4] + G[8])),
        2 * (x * (G[1] + G[3]) + z * (G[5] + G[7]) + w * (G[2] - G[6]) - 2 * y * (G[0] + G[8])),
        2 * (x * (G[2] + G[6]) + y * (G[5] + G[7]) + w * (G[3] - G[1]) - 2 * z * (G[0] + G[4])),
    };
    const lt_real along = u[0] * g[0] + u[1] * g[1] + u[2] * g[2] + u[3] * g[3];

    for (int i = 0; i < 4; i++)
        dq[i] += (g[i] - u[i] * along) / n;
}

static void quaternion_block(const lt_call *c, const lt_real *scale, int64_t from, int64_t to)
{
    const int64_t step = splat_step(c->in[TRANSFORMS], count(c));
    const lt_real *q = c->in[QUATERNION]->data, *T = c->in[TRANSFORMS]->data;

#pragma omp simd
    for (int64_t i = from; i < to; i++) {
        lt_real u[4], G[9];
        const lt_real n = unit(q + 4 * i, u);

        rotation_gradient(T + i * step, scale + 3 * (i - from), c->dout + 9 * i, G);
        quaternion_gradient(u, n, G, c->din[QUATERNION] + 4 * i);
    }
}

static void scale_block(const lt_call *c, int64_t from, int64_t to)
{
    const lt_real *axes = c->out->data;

#pragma omp simd
    for (int64_t i = from; i < to; i++)
        for (int k = 0; k < 3; k++) {
            const lt_real *M = axes + 9 * i + k, *dM = c->dout + 9 * i + k;

            c->din[SCALE][3 * i + k] += M[0] * dM[0] + M[3] * dM[3] + M[6] * dM[6];
        }
}

/* dM (R S)^T, a row of A after the other, to each transform or to the sum of all */
static void transform_block(const lt_call *c, const lt_real *scale, int64_t from, int64_t to)
{
    const bool own = splat_step(c->in[TRANSFORMS], count(c));
    const lt_real *q = c->in[QUATERNION]->data;
    double *shared = own ? NULL : splat_shared(c, from);

    for (int64_t i = from; i < to; i++) {
        const lt_real *s = scale + 3 * (i - from), *dM = c->dout + 9 * i;
        lt_real u[4], R[9];

        unit(q + 4 * i, u);
        rotation(u, R);
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) {
                const lt_real g = dM[3 * a] * R[3 * b] * s[0] + dM[3 * a + 1] * R[3 * b + 1] * s[1]
                                + dM[3 * a + 2] * R[3 * b + 2] * s[2];

                if (own)
                    c->din[TRANSFORMS][12 * i + 4 * a + b] += g;
                else
                    shared[4 * a + b] += g;
            }
    }
}

static void backward_block(const lt_call *c, int64_t from, int64_t to)
{
    lt_real scale[3 * SPLAT_ROWS];

    lt_k->exp(scale, (const lt_real *)c->in[SCALE]->data + 3 * from, (size_t)(3 * (to - from)));
    if (c->din[SCALE])
        scale_block(c, from, to);
    if (c->din[QUATERNION])
        quaternion_block(c, scale, from, to);
    if (c->din[TRANSFORMS])
        transform_block(c, scale, from, to);
}

static void forward(const lt_call *c)
{
    splat_by_block(c, count(c), forward_block);
}

static void backward(const lt_call *c)
{
    splat_by_block(c, count(c), backward_block);
    splat_add_shared(c, TRANSFORMS, count(c));
}

static const lt_op splat_axes_op = {
    .name = "splat_axes", .infer = infer, .plan = plan, .forward = forward, .backward = backward,
};

lt_tensor *(lt_splat_axes)(lt_tensor *log_scale, lt_tensor *quaternion, lt_tensor *transforms)
{
    return lt_apply(&splat_axes_op, NULL, 0, (lt_tensor *[]){ log_scale, quaternion, transforms }, 3);
}
