/* SPDX-License-Identifier: Apache-2.0 */
/* farthest_point_sampling: n points that cover all of them, each the one farthest from those before it.
 *                                                                                     [Qi et al. 2017, section 3.2]
 *   points (B, N, 3)   start (B), integers, may be left out: 0   ->   index (B, n), integers: the first is start; of
 *                                                                     points equally far the one with the lower index
 *
 * No gradient. A point that is not finite is never chosen but as the start; where every point has been chosen, index
 * goes on with the first one.
 */
#include "libtensor/ops/points/planes.h"

enum { POINTS, START };

typedef struct { int64_t n; } farthest_attr;

static lt_status infer(lt_call *c)
{
    const farthest_attr *a = c->attr;
    char text[LT_SHAPE_TEXT];

    if (op_want_points(c, POINTS, "points"))
        return LT_ESHAPE;
    if (c->in[START] && (c->in[START]->dtype != LT_I32 || lt_numel(c->in[START]) != lt_dim(c->in[POINTS], 0)))
        return lt_fail(c, "start is %s%s, want one integer for each of %lld sets",
                       lt_shape_text(&c->in[START]->shape, text), c->in[START]->dtype == LT_I32 ? "" : " and no LT_I32",
                       (long long)lt_dim(c->in[POINTS], 0));
    if (a->n < 1)
        return lt_fail(c, "%lld points of each set, want at least one", (long long)a->n);
    c->out->shape = LT_SHAPE(lt_dim(c->in[POINTS], 0), a->n);
    c->out->dtype = LT_I32;
    return LT_OK;
}

/* work: the planes, then each point's squared distance from those that are chosen */
static void plan(lt_call *c)
{
    const int64_t B = lt_dim(c->in[POINTS], 0), N = lt_dim(c->in[POINTS], 1);

    c->work_bytes = op_planes_work(B, N) + (size_t)(B * op_plane_length(N)) * sizeof(lt_real);
}

static void choose(void *ctx, int64_t b)
{
    const lt_call *c = ctx;
    const farthest_attr *a = c->attr;
    const int64_t B = lt_dim(c->in[POINTS], 0), N = lt_dim(c->in[POINTS], 1), ld = op_plane_length(N);
    const lt_real *x = (const lt_real *)c->work + b * 3 * ld;
    lt_real *d = (lt_real *)c->work + B * 3 * ld + b * ld;
    int32_t *index = (int32_t *)c->out->data + b * a->n;
    int64_t at = c->in[START] ? ((const int32_t *)c->in[START]->data)[b] : 0;

    at = at >= 0 && at < N ? at : 0;
    for (int64_t i = 0; i < ld; i++)
        d[i] = x[i] == x[i] ? (lt_real)INFINITY : -1;
    for (int64_t k = 0; k < a->n; k++) {
        index[k] = (int32_t)at;
        at = lt_k->farthest_point(d, x, ld, (lt_real[]){ x[at], x[ld + at], x[2 * ld + at] });
    }
}

static void forward(const lt_call *c)
{
    op_planes(c, POINTS, c->work);
    lt_parallel_for(lt_dim(c->in[POINTS], 0), choose, (void *)c);
}

static const lt_op farthest_point_sampling_op = {
    .name = "farthest_point_sampling", .flags = LT_OP_DETACH, .optional = LT_OPTIONAL_IN(START),
    .any_type = LT_ANY_TYPE_IN(START), .infer = infer, .plan = plan, .forward = forward,
};

lt_tensor *(lt_farthest_point_sampling)(lt_tensor *points, lt_tensor *start, int64_t n)
{
    const farthest_attr a = { n };

    return lt_apply(&farthest_point_sampling_op, &a, sizeof(a), (lt_tensor *[]){ points, start }, 2);
}
