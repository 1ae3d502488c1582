/* SPDX-License-Identifier: Apache-2.0 */
/* group: what is known of the points around each centre, as maps of a row a centre.       [Qi et al. 2017, section 3.2]
 *   x (B, C, N)   centre (B, C, M), may be left out   index (B, M, K), integers   ->   y (B, C, M, K):
 *   y[b, c, m, k] = x[b, c, index[b, m, k]] - centre[b, c, m]          x counts as 0 where it has no such point
 *   dx[b, c, index] += dy        dcentre[b, c, m] -= sum_k dy          by channel, in the order of m and k
 */
#include "libtensor/ops/common.h"

enum { X, CENTRE, INDEX };

static lt_status infer(lt_call *c)
{
    const lt_tensor *x = c->in[X], *index = c->in[INDEX];
    char text[LT_SHAPE_TEXT];

    if (lt_want_rank(c, X, "its input", 3))
        return LT_ESHAPE;
    if (index->dtype != LT_I32 || index->shape.rank != 3 || lt_dim(index, 0) != lt_dim(x, 0))
        return lt_fail(c, "the index is %s%s, want (%lld, centres, points) of integers",
                       lt_shape_text(&index->shape, text), index->dtype == LT_I32 ? "" : " and no LT_I32",
                       (long long)lt_dim(x, 0));
    if (c->in[CENTRE]
        && lt_want_shape(c, CENTRE, "centre", LT_SHAPE(lt_dim(x, 0), lt_dim(x, 1), lt_dim(index, 1))))
        return LT_ESHAPE;
    c->out->shape = LT_SHAPE(lt_dim(x, 0), lt_dim(x, 1), lt_dim(index, 1), lt_dim(index, 2));
    return LT_OK;
}

/* work: the index, -1 for points that x does not have */
static void plan(lt_call *c)
{
    c->work_bytes = (size_t)lt_numel(c->in[INDEX]) * sizeof(int32_t);
}

static int64_t planes_of(const lt_call *c)
{
    return op_outer(c->out, 2);
}

/* The index of a plane's set */
static const int32_t *index_of(const lt_call *c, int64_t plane)
{
    return (const int32_t *)c->in[INDEX]->data + plane / lt_dim(c->in[X], 1) * op_inner(c->in[INDEX], 0);
}

static void forward_plane(const lt_call *c, int64_t plane)
{
    const int64_t N = lt_dim(c->in[X], 2), M = lt_dim(c->out, 2), K = lt_dim(c->out, 3);
    const lt_real *x = (const lt_real *)c->in[X]->data + plane * N;
    const lt_real *centre = c->in[CENTRE] ? (const lt_real *)c->in[CENTRE]->data + plane * M : NULL;
    const int32_t *index = (const int32_t *)c->work + plane / lt_dim(c->in[X], 1) * M * K;
    lt_real *y = (lt_real *)c->out->data + plane * M * K;

    for (int64_t m = 0; m < M; m++)
        lt_k->take_from(y + m * K, x, index + m * K, centre ? centre[m] : 0, (size_t)K);
}

static void forward(const lt_call *c)
{
    const int32_t *index = c->in[INDEX]->data;
    int32_t *safe = c->work;

    for (int64_t i = 0; i < lt_numel(c->in[INDEX]); i++)
        safe[i] = index[i] < lt_dim(c->in[X], 2) ? index[i] : -1;
    op_by_row(c, planes_of(c), op_inner(c->out, 1), forward_plane);
}

static void backward_plane(const lt_call *c, int64_t plane)
{
    const int64_t N = lt_dim(c->in[X], 2), M = lt_dim(c->out, 2), K = lt_dim(c->out, 3);
    const lt_real *dy = c->dout + plane * M * K;
    const int32_t *index = index_of(c, plane);

    op_start(c, X, plane * N, N);
    op_start(c, CENTRE, plane * M, M);
    for (int64_t i = 0; c->din[X] && i < M * K; i++)
        if (index[i] >= 0 && index[i] < N)
            c->din[X][plane * N + index[i]] += dy[i];
    for (int64_t m = 0; c->in[CENTRE] && c->din[CENTRE] && m < M; m++)
        c->din[CENTRE][plane * M + m] -= (lt_real)lt_k->sum(dy + m * K, (size_t)K);
}

static void backward(const lt_call *c)
{
    op_by_row(c, planes_of(c), op_inner(c->out, 1), backward_plane);
}

static const lt_op group_op = {
    .name = "group", .flags = LT_OP_ASSIGNS, .keeps = LT_KEEP_IN(INDEX), .optional = LT_OPTIONAL_IN(CENTRE),
    .any_type = LT_ANY_TYPE_IN(INDEX), .infer = infer, .plan = plan, .forward = forward, .backward = backward,
};

lt_tensor *(lt_group)(lt_tensor *x, lt_tensor *centre, lt_tensor *index)
{
    return lt_apply(&group_op, NULL, 0, (lt_tensor *[]){ x, centre, index }, 3);
}
