/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/ops/points/planes.h"

lt_status op_want_points(lt_call *c, int i, const char *what)
{
    char text[LT_SHAPE_TEXT];

    if (lt_want_rank(c, i, what, 3))
        return LT_ESHAPE;
    if (lt_dim(c->in[i], 2) != 3 || lt_dim(c->in[i], 1) < 1 || lt_dim(c->in[i], 1) > INT32_MAX - LT_POINTS)
        return lt_fail(c, "%s is %s, want (batch, points, 3) with at least one point", what,
                       lt_shape_text(&c->in[i]->shape, text));
    return LT_OK;
}

size_t op_planes_work(int64_t B, int64_t n)
{
    return (size_t)(B * 3 * op_plane_length(n)) * sizeof(lt_real);
}

typedef struct {
    const lt_tensor *points;
    lt_real *planes;
} planes_job;

static void fill(void *ctx, int64_t b)
{
    const planes_job *job = ctx;
    const int64_t n = lt_dim(job->points, 1), ld = op_plane_length(n);
    const lt_real *p = (const lt_real *)job->points->data + b * n * 3;
    lt_real *x = job->planes + b * 3 * ld;

    for (int64_t i = 0; i < n; i++, p += 3) {
        const bool finite = isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);

        for (int a = 0; a < 3; a++)
            x[a * ld + i] = finite ? p[a] : (lt_real)NAN;
    }
    for (int64_t i = n; i < ld; i++)
        for (int a = 0; a < 3; a++)
            x[a * ld + i] = (lt_real)NAN;
}

void op_planes(const lt_call *c, int i, lt_real *planes)
{
    planes_job job = { c->in[i], planes };

    lt_parallel_for(lt_dim(c->in[i], 0), fill, &job);
}
