/* SPDX-License-Identifier: Apache-2.0 */
/* ball_query: for each centre the first points within a radius of it.                     [Qi et al. 2017, section 3.2]
 *   points (B, N, 3)   centres (B, M, 3)   ->   index (B, M, n), integers: ascending; fewer than n are followed by the
 *                                               first of them again, and none is -1 everywhere
 *
 * No gradient. A point at the radius is within.
 */
#include "libtensor/ops/points/planes.h"

enum { POINTS, CENTRES };

typedef struct {
    double radius;
    int64_t n;
} ball_attr;

static lt_status infer(lt_call *c)
{
    const ball_attr *a = c->attr;

    if (op_want_points(c, POINTS, "points") || op_want_points(c, CENTRES, "centres"))
        return LT_ESHAPE;
    if (lt_dim(c->in[POINTS], 0) != lt_dim(c->in[CENTRES], 0))
        return lt_fail(c, "points of %lld sets, centres of %lld", (long long)lt_dim(c->in[POINTS], 0),
                       (long long)lt_dim(c->in[CENTRES], 0));
    if (!(a->radius > 0) || a->n < 1)
        return lt_fail(c, "%lld points within %g, want at least one and a radius above 0", (long long)a->n, a->radius);
    c->out->shape = LT_SHAPE(lt_dim(c->in[CENTRES], 0), lt_dim(c->in[CENTRES], 1), a->n);
    c->out->dtype = LT_I32;
    return LT_OK;
}

static void plan(lt_call *c)
{
    c->work_bytes = op_planes_work(lt_dim(c->in[POINTS], 0), lt_dim(c->in[POINTS], 1));
}

static void query(const lt_call *c, int64_t row)
{
    const ball_attr *a = c->attr;
    const int64_t ld = op_plane_length(lt_dim(c->in[POINTS], 1));
    const lt_real *x = (const lt_real *)c->work + row / lt_dim(c->in[CENTRES], 1) * 3 * ld;
    int32_t *index = (int32_t *)c->out->data + row * a->n;
    const int64_t found = lt_k->points_within(index, a->n, x, ld, (const lt_real *)c->in[CENTRES]->data + 3 * row,
                                              (lt_real)(a->radius * a->radius));

    for (int64_t i = found; i < a->n; i++)
        index[i] = found ? index[0] : -1;
}

static void forward(const lt_call *c)
{
    op_planes(c, POINTS, c->work);
    op_by_row(c, op_outer(c->in[CENTRES], 2), lt_dim(c->in[POINTS], 1), query);
}

static const lt_op ball_query_op = {
    .name = "ball_query", .flags = LT_OP_DETACH, .infer = infer, .plan = plan, .forward = forward,
};

lt_tensor *(lt_ball_query)(lt_tensor *points, lt_tensor *centres, double radius, int64_t n)
{
    const ball_attr a = { radius, n };

    return lt_apply(&ball_query_op, &a, sizeof(a), (lt_tensor *[]){ points, centres }, 2);
}
