/* SPDX-License-Identifier: Apache-2.0 */
/* transform_points: y = A x + t;  transform_back: y = A^T x. Each point has its [A | t], or all share one.
 *   points (N, 3)   transforms (N, 3, 4) or (1, 3, 4)   ->   y (N, 3)
 *   points:   dx += A^T dy     dA += dy x^T     dt += dy
 *   back:     dx += A dy       dA += x dy^T
 */
#include "libtensor/ops/splat/rows.h"

enum { POINTS, TRANSFORMS };

typedef struct { bool back; } transform_attr;

static lt_status infer(lt_call *c)
{
    if (lt_want_rank(c, POINTS, "points", 2))
        return LT_ESHAPE;
    if (lt_want_shape(c, POINTS, "points", LT_SHAPE(lt_dim(c->in[POINTS], 0), 3))
        || splat_want_transforms(c, TRANSFORMS, lt_dim(c->in[POINTS], 0)))
        return LT_ESHAPE;
    c->out->shape = c->in[POINTS]->shape;
    return LT_OK;
}

static int64_t count(const lt_call *c)
{
    return lt_dim(c->in[POINTS], 0);
}

static void plan(lt_call *c)
{
    c->work_bytes = splat_shared_bytes(c, TRANSFORMS, count(c));
}

static bool goes_back(const lt_call *c)
{
    return ((const transform_attr *)c->attr)->back;
}

/* y = or += A x + t */
static void there(lt_real *y, const lt_real *T, int64_t step, const lt_real *x, int64_t n, bool add, bool move)
{
#pragma omp simd
    for (int64_t i = 0; i < n; i++)
        for (int a = 0; a < 3; a++) {
            const lt_real *row = T + i * step + 4 * a;
            const lt_real sum = row[0] * x[3 * i] + row[1] * x[3 * i + 1] + row[2] * x[3 * i + 2]
                              + (move ? row[3] : 0);

            y[3 * i + a] = add ? y[3 * i + a] + sum : sum;
        }
}

/* y = or += A^T x */
static void back(lt_real *y, const lt_real *T, int64_t step, const lt_real *x, int64_t n, bool add)
{
#pragma omp simd
    for (int64_t i = 0; i < n; i++)
        for (int a = 0; a < 3; a++) {
            const lt_real *column = T + i * step + a;
            const lt_real sum = column[0] * x[3 * i] + column[4] * x[3 * i + 1] + column[8] * x[3 * i + 2];

            y[3 * i + a] = add ? y[3 * i + a] + sum : sum;
        }
}

static void forward_block(const lt_call *c, int64_t from, int64_t to)
{
    const int64_t step = splat_step(c->in[TRANSFORMS], count(c)), n = to - from;
    const lt_real *x = (const lt_real *)c->in[POINTS]->data + 3 * from;
    const lt_real *T = (const lt_real *)c->in[TRANSFORMS]->data + step * from;
    lt_real *y = (lt_real *)c->out->data + 3 * from;

    if (goes_back(c))
        back(y, T, step, x, n, false);
    else
        there(y, T, step, x, n, false, true);
}

/* dT[a, b] += u_a v_b, and dt += u where they moved: of own transforms */
static void own_gradient(lt_real *dT, const lt_real *u, const lt_real *v, int64_t n, bool moved)
{
#pragma omp simd
    for (int64_t i = 0; i < n; i++)
        for (int a = 0; a < 3; a++) {
            for (int b = 0; b < 3; b++)
                dT[12 * i + 4 * a + b] += u[3 * i + a] * v[3 * i + b];
            dT[12 * i + 4 * a + 3] += moved ? u[3 * i + a] : 0;
        }
}

static void shared_gradient(double *dT, const lt_real *u, const lt_real *v, int64_t n, bool moved)
{
    for (int64_t i = 0; i < n; i++)
        for (int a = 0; a < 3; a++) {
            for (int b = 0; b < 3; b++)
                dT[4 * a + b] += (double)u[3 * i + a] * v[3 * i + b];
            dT[4 * a + 3] += moved ? u[3 * i + a] : 0;
        }
}

static void backward_block(const lt_call *c, int64_t from, int64_t to)
{
    const int64_t step = splat_step(c->in[TRANSFORMS], count(c)), n = to - from;
    const lt_real *x = (const lt_real *)c->in[POINTS]->data + 3 * from, *dy = c->dout + 3 * from;
    const lt_real *T = (const lt_real *)c->in[TRANSFORMS]->data + step * from;
    const lt_real *u = goes_back(c) ? x : dy, *v = goes_back(c) ? dy : x;

    if (c->din[POINTS] && goes_back(c))
        there(c->din[POINTS] + 3 * from, T, step, dy, n, true, false);
    else if (c->din[POINTS])
        back(c->din[POINTS] + 3 * from, T, step, dy, n, true);
    if (c->din[TRANSFORMS] && step)
        own_gradient(c->din[TRANSFORMS] + 12 * from, u, v, n, !goes_back(c));
    else if (c->din[TRANSFORMS])
        shared_gradient(splat_shared(c, from), u, v, n, !goes_back(c));
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

static const lt_op transform_points_op = {
    .name = "transform_points", .keeps = LT_KEEP_IN(POINTS) | LT_KEEP_IN(TRANSFORMS), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward,
};

static const lt_op transform_back_op = {
    .name = "transform_back", .keeps = LT_KEEP_IN(POINTS) | LT_KEEP_IN(TRANSFORMS), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward,
};

lt_tensor *(lt_transform_points)(lt_tensor *points, lt_tensor *transforms)
{
    const transform_attr a = { .back = false };

    return lt_apply(&transform_points_op, &a, sizeof(a), (lt_tensor *[]){ points, transforms }, 2);
}

lt_tensor *(lt_transform_back)(lt_tensor *points, lt_tensor *transforms)
{
    const transform_attr a = { .back = true };

    return lt_apply(&transform_back_op, &a, sizeof(a), (lt_tensor *[]){ points, transforms }, 2);
}

lt_tensor *(lt_blend_transforms)(lt_tensor *weights, lt_tensor *transforms)
{
    lt_tensor *flat = lt_reshape(transforms, LT_SHAPE(lt_dim(transforms, 0), 12));

    return lt_reshape(lt_matmul(weights, flat), LT_SHAPE(lt_dim(weights, 0), 3, 4));
}
