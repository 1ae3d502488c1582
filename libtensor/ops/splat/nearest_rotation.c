/* SPDX-License-Identifier: Apache-2.0 */
/* nearest_rotation: the polar projection of matrices.                [Higham 1986, "Computing the polar decomposition"]
 *   X (..., 3, 3)   otherwise, of the same shape   ->   R, X = R P with P symmetric and positive
 *   With G = dR, H = R^T X:   dX += R [y]x,   y = (tr(H) I - H)^-1 vee(R^T G - G^T R)
 *
 * Where det X is not above 0, R is `otherwise`, and X gets no gradient.
 */
#include "libtensor/geometry/mat3.h"
#include "libtensor/ops/common.h"
#include "libtensor/ops/splat/gaussians.h"

enum { MATRIX, OTHERWISE };

static lt_status infer(lt_call *c)
{
    const lt_tensor *X = c->in[MATRIX];
    char text[LT_SHAPE_TEXT];

    if (X->shape.rank < 2 || lt_dim(X, -1) != 3 || lt_dim(X, -2) != 3)
        return lt_fail(c, "X is %s, want (..., 3, 3)", lt_shape_text(&X->shape, text));
    if (lt_want_shape(c, OTHERWISE, "otherwise", X->shape))
        return LT_ESHAPE;
    c->out->shape = X->shape;
    return LT_OK;
}

/* y = X^-T: the matrix of cofactors, divided by the determinant */
static void inverse_transposed(const double X[9], double det, double y[9])
{
    for (int i = 0; i < 3; i++) {
        const double *a = X + 3 * ((i + 1) % 3), *b = X + 3 * ((i + 2) % 3);

        lt_vec3_cross(a, b, y + 3 * i);
        for (int j = 0; j < 3; j++)
            y[3 * i + j] /= det;
    }
}

/* Newton's iteration X <- (X + X^-T) / 2; false where X has no rotation near it */
static bool project(const lt_real *from, double X[9])
{
    double change = 1, other[9];

    for (int i = 0; i < 9; i++)
        X[i] = from[i];
    if (!lt_all_finite(9, X) || !(lt_mat3_det(X) > 0))
        return false;
    for (int step = 0; change > 1e-7 && step < 100; step++) {
        inverse_transposed(X, lt_mat3_det(X), other);
        change = 0;
        for (int i = 0; i < 9; i++) {
            const double y = (X[i] + other[i]) / 2;

            change = fmax(change, fabs(y - X[i]));
            X[i] = y;
        }
    }
    return lt_all_finite(9, X) && change <= 1e-7;
}

static void forward_one(const lt_call *c, int64_t k)
{
    const lt_real *otherwise = (const lt_real *)c->in[OTHERWISE]->data + 9 * k;
    lt_real *R = (lt_real *)c->out->data + 9 * k;
    double X[9];
    const bool found = project((const lt_real *)c->in[MATRIX]->data + 9 * k, X);

    for (int i = 0; i < 9; i++)
        R[i] = found ? (lt_real)X[i] : otherwise[i];
}

static void backward_one(const lt_call *c, int64_t k)
{
    const lt_real *from = (const lt_real *)c->in[MATRIX]->data + 9 * k, *dR = c->dout + 9 * k;
    double R[9], Rt[9], X[9], G[9], H[9], W[9], K[9], v[3], y[3], cross[9], dX[9], trace;

    if (!project(from, R))
        return;
    for (int i = 0; i < 9; i++) {
        X[i] = from[i];
        G[i] = dR[i];
    }
    lt_mat3_transpose(R, Rt);
    lt_mat3_mul(Rt, X, H);
    lt_mat3_mul(Rt, G, W);
    v[0] = W[7] - W[5], v[1] = W[2] - W[6], v[2] = W[3] - W[1];
    trace = H[0] + H[4] + H[8];
    for (int i = 0; i < 9; i++)
        H[i] = (i % 4 == 0 ? trace : 0) - H[i];
    inverse_transposed(H, lt_mat3_det(H), K);           /* not transposed: symmetric, as H is */
    lt_mat3_mulvec(K, v, y);
    memcpy(cross, (double[9]){ 0, -y[2], y[1], y[2], 0, -y[0], -y[1], y[0], 0 }, sizeof(cross));
    lt_mat3_mul(R, cross, dX);
    for (int i = 0; i < 9; i++)
        c->din[MATRIX][9 * k + i] += (lt_real)dX[i];
}

static void forward(const lt_call *c)
{
    op_by_row(c, lt_numel(c->out) / 9, 500, forward_one);
}

static void backward(const lt_call *c)
{
    if (c->din[MATRIX])
        op_by_row(c, lt_numel(c->out) / 9, 1000, backward_one);
}

static const lt_op nearest_rotation_op = {
    .name = "nearest_rotation", .keeps = LT_KEEP_IN(MATRIX), .infer = infer, .forward = forward,
    .backward = backward,
};

lt_tensor *(lt_nearest_rotation)(lt_tensor *X, lt_tensor *otherwise)
{
    return lt_apply(&nearest_rotation_op, NULL, 0, (lt_tensor *[]){ X, otherwise }, 2);
}
