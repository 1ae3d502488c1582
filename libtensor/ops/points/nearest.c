/* SPDX-License-Identifier: Apache-2.0 */
/* nearest: how far each point is from the nearest of others.
 *   a (B, N, 3)   b (B, M, 3)   ->   d (B, N) = |a_i - b_j|, and j (B, N), integers: the first of the nearest
 *   da_i += dd (a_i - b_j) / d        db_j -= the same, in the order of i        0 where d is 0, or no number
 */
#include "libtensor/ops/points/planes.h"

enum { FROM, TO };

static lt_status infer(lt_call *c)
{
    if (op_want_points(c, FROM, "points") || op_want_points(c, TO, "others"))
        return LT_ESHAPE;
    if (lt_dim(c->in[FROM], 0) != lt_dim(c->in[TO], 0))
        return lt_fail(c, "points of %lld sets, others of %lld", (long long)lt_dim(c->in[FROM], 0),
                       (long long)lt_dim(c->in[TO], 0));
    c->outs[0]->shape = c->outs[1]->shape = LT_SHAPE(lt_dim(c->in[FROM], 0), lt_dim(c->in[FROM], 1));
    c->outs[1]->dtype = LT_I32;
    return LT_OK;
}

static void plan(lt_call *c)
{
    c->work_bytes = op_planes_work(lt_dim(c->in[TO], 0), lt_dim(c->in[TO], 1));
}

static const lt_real *place(const lt_call *c, int i, int64_t point)
{
    return (const lt_real *)c->in[i]->data + 3 * point;
}

static void forward_row(const lt_call *c, int64_t row)
{
    const int64_t ld = op_plane_length(lt_dim(c->in[TO], 1));
    const lt_real *planes = (const lt_real *)c->work + row / lt_dim(c->out, 1) * 3 * ld;
    lt_real square;

    ((int32_t *)c->outs[1]->data)[row] = (int32_t)lt_k->nearest_point(&square, planes, ld, place(c, FROM, row));
    ((lt_real *)c->out->data)[row] = (lt_real)sqrt((double)square);
}

static void forward(const lt_call *c)
{
    op_planes(c, TO, c->work);
    op_by_row(c, lt_numel(c->out), lt_dim(c->in[TO], 1), forward_row);
}

static void backward_set(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    const int64_t N = lt_dim(c->out, 1), M = lt_dim(c->in[TO], 1);

    for (int64_t row = b * N; row < (b + 1) * N; row++) {
        const int64_t to = b * M + ((const int32_t *)c->outs[1]->data)[row];
        const lt_real d = ((const lt_real *)c->out->data)[row];

        for (int a = 0; d > 0 && isfinite(d) && a < 3; a++) {
            const lt_real g = c->dout[row] * (place(c, FROM, row)[a] - place(c, TO, to)[a]) / d;

            if (c->din[FROM])
                c->din[FROM][3 * row + a] += g;
            if (c->din[TO])
                c->din[TO][3 * to + a] -= g;
        }
    }
}

static void backward(const lt_call *c)
{
    if (c->dout)
        lt_parallel_for(lt_dim(c->out, 0), backward_set, (void *)c);
}

static const lt_op nearest_op = {
    .name = "nearest", .n_out = 2,
    .keeps = LT_KEEP_IN(FROM) | LT_KEEP_IN(TO) | LT_KEEP_OUT(0) | LT_KEEP_OUT(1), .infer = infer, .plan = plan,
    .forward = forward, .backward = backward,
};

lt_tensor *(lt_nearest)(lt_tensor *points, lt_tensor *others)
{
    return lt_apply(&nearest_op, NULL, 0, (lt_tensor *[]){ points, others }, 2);
}
