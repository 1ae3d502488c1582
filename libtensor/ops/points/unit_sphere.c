/* SPDX-License-Identifier: Apache-2.0 */
/* unit_sphere: points about their mean, the farthest at distance 1.                                 [Qi et al. 2017]
 *   points (B, N, 3)   count (B), integers, may be left out   ->   y (B, N, 3) = (points - mean) / largest distance
 *
 * Mean and distance are of the first count points of a set, all without count. No gradient. Where all are in one place,
 * or none is there, they are not divided.
 */
#include "libtensor/ops/points/planes.h"

enum { POINTS, COUNT };

static lt_status infer(lt_call *c)
{
    char text[LT_SHAPE_TEXT];

    if (op_want_points(c, POINTS, "points"))
        return LT_ESHAPE;
    if (c->in[COUNT] && (c->in[COUNT]->dtype != LT_I32 || lt_numel(c->in[COUNT]) != lt_dim(c->in[POINTS], 0)))
        return lt_fail(c, "count is %s%s, want one integer for each of %lld sets",
                       lt_shape_text(&c->in[COUNT]->shape, text), c->in[COUNT]->dtype == LT_I32 ? "" : " and no LT_I32",
                       (long long)lt_dim(c->in[POINTS], 0));
    return op_same_shape(c);
}

static void mean_of(double mean[3], const lt_real *p, int64_t n)
{
    memset(mean, 0, 3 * sizeof(*mean));
    for (int64_t i = 0; i < n; i++)
        for (int a = 0; a < 3; a++)
            mean[a] += p[3 * i + a];
    for (int a = 0; n && a < 3; a++)
        mean[a] /= (double)n;
}

static double radius_of(const double mean[3], const lt_real *p, int64_t n)
{
    double most = 0;

    for (int64_t i = 0; i < n; i++, p += 3) {
        const double d[3] = { p[0] - mean[0], p[1] - mean[1], p[2] - mean[2] };

        most = fmax(most, d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    }
    return sqrt(most);
}

static void forward_set(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    const int64_t N = lt_dim(c->out, 1);
    const lt_real *p = (const lt_real *)c->in[POINTS]->data + b * N * 3;
    const int64_t count = c->in[COUNT] ? ((const int32_t *)c->in[COUNT]->data)[b] : N;
    const int64_t n = lt_max_i64(0, lt_min_i64(N, count));
    lt_real *y = (lt_real *)c->out->data + b * N * 3;
    double mean[3], radius;

    mean_of(mean, p, n);
    radius = radius_of(mean, p, n);
    for (int64_t i = 0; i < 3 * N; i++)
        y[i] = (lt_real)((p[i] - mean[i % 3]) / (radius > 0 ? radius : 1));
}

static void forward(const lt_call *c)
{
    lt_parallel_for(lt_dim(c->out, 0), forward_set, (void *)c);
}

static const lt_op unit_sphere_op = {
    .name = "unit_sphere", .flags = LT_OP_DETACH, .optional = LT_OPTIONAL_IN(COUNT),
    .any_type = LT_ANY_TYPE_IN(COUNT), .infer = infer, .forward = forward,
};

lt_tensor *(lt_unit_sphere)(lt_tensor *points, lt_tensor *count)
{
    return lt_apply(&unit_sphere_op, NULL, 0, (lt_tensor *[]){ points, count }, 2);
}
