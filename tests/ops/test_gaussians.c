/* SPDX-License-Identifier: Apache-2.0 */
/* From a hand's Gaussians to what is drawn of them: rows of zeros behind the last change nothing, and learn nothing. */
#include "libtensor/graph/plan.h"
#include "libtensor/ops/ops.h"
#include "libtensor/ops/splat/gaussians.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { MOST = 9, BONES = 4, OUTPUTS = 4 };

/* What each Gaussian has, so many numbers of each */
static const struct { const char *name; int64_t width[2]; } per_row[] = {
    { "centre", { 3, 1 } }, { "log_scale", { 3, 1 } }, { "quaternion", { 4, 1 } }, { "delta", { 4, 1 } },
    { "weights", { BONES, 1 } }, { "sh", { 16, 3 } },
};
enum { KINDS = 6 };

typedef struct {
    lt_graph *g;
    lt_plan *plan;
    lt_tensor *in[KINDS], *bones, *alive, *out[OUTPUTS];
} chain;

static lt_tensor *input(lt_graph *g, int kind, int64_t n)
{
    const int64_t *w = per_row[kind].width;
    const int64_t dim[3] = { n, w[0], w[1] };

    return lt_want_grad(lt_input(g, per_row[kind].name, LT_F32, w[1] > 1 ? 3 : 2, dim));
}

/* Every output of the living, summed */
static lt_tensor *sum_alive(const chain *c, int64_t n)
{
    lt_tensor *loss = NULL;

    for (int i = 0; i < OUTPUTS; i++) {
        lt_tensor *flat = lt_reshape(c->out[i], LT_SHAPE(n, lt_numel(c->out[i]) / n));
        lt_tensor *part = lt_sum(lt_mul(flat, c->alive));

        loss = loss ? lt_add(loss, part) : part;
    }
    return loss;
}

static chain record(int64_t n)
{
    const int32_t degree = 3;
    chain c = { .g = lt_graph_new() };
    lt_tensor *T, *loss;

    for (int i = 0; i < KINDS; i++)
        c.in[i] = input(c.g, i, n);
    c.bones = lt_input(c.g, "bones", LT_F32, 3, (int64_t[]){ BONES, 3, 4 });
    c.alive = lt_input(c.g, "alive", LT_F32, 2, (int64_t[]){ n, 1 });
    T = lt_blend_transforms(c.in[4], c.bones);
    c.out[0] = lt_transform_points(c.in[0], T);
    c.out[1] = lt_splat_axes(c.in[1], lt_quaternion_turn(c.in[2], c.in[3]), T);
    c.out[2] = lt_sh_colour(c.in[5], lt_transform_back(c.out[0], lt_detach(T)),
                            lt_constant(c.g, LT_I32, (lt_shape){ 0 }, &degree));
    c.out[3] = lt_splat_covariance(c.out[1]);
    for (int i = 0; i < OUTPUTS; i++)
        lt_output(c.out[i], "out");
    loss = sum_alive(&c, n);
    c.plan = lt_compile(c.g, &(lt_compile_opts){ .loss = loss, .train = true });
    ck_assert_msg(c.plan, "%s", lt_last_error());
    return c;
}

static void fill(const chain *c, int64_t n, int64_t alive)
{
    lt_rng r = lt_rng_make(5, 0);
    lt_real *bones = lt_plan_data(c->plan, c->bones), *mask = lt_plan_data(c->plan, c->alive);

    for (int i = 0; i < 12 * BONES; i++)
        bones[i] = (lt_real)lt_rng_uniform(&r);
    for (int64_t i = 0; i < n; i++)
        mask[i] = i < alive;
    for (int k = 0; k < KINDS; k++) {
        const int64_t w = per_row[k].width[0] * per_row[k].width[1];
        lt_real *x = lt_plan_data(c->plan, c->in[k]);

        memset(x, 0, (size_t)(n * w) * sizeof(*x));
        for (int64_t i = 0; i < alive * w; i++)
            x[i] = (lt_real)lt_rng_uniform(&r) - (lt_real)0.5;
    }
}

START_TEST(rows_of_zeros)
{
    enum { ALIVE = 5 };
    chain some = record(ALIVE), padded = record(MOST);

    fill(&some, ALIVE, ALIVE);
    fill(&padded, MOST, ALIVE);
    ck_assert_int_eq(lt_run(some.plan), LT_OK);
    ck_assert_int_eq(lt_run(padded.plan), LT_OK);
    for (int i = 0; i < OUTPUTS; i++) {
        const lt_real *x = lt_plan_data(some.plan, some.out[i]), *y = lt_plan_data(padded.plan, padded.out[i]);

        ck_assert_mem_eq(x, y, lt_nbytes(some.out[i]));
        for (int64_t j = 0; j < lt_numel(padded.out[i]); j++)
            ck_assert(isfinite(y[j]));
    }
    for (int k = 0; k < KINDS; k++) {
        const lt_real *x = lt_plan_grad(some.plan, some.in[k]), *y = lt_plan_grad(padded.plan, padded.in[k]);
        const int64_t n = lt_numel(some.in[k]);

        ck_assert_mem_eq(x, y, lt_nbytes(some.in[k]));
        for (int64_t j = n; j < lt_numel(padded.in[k]); j++)
            ck_assert_msg(y[j] == 0, "%s[%d] learns %g", per_row[k].name, (int)j, (double)y[j]);
    }
    lt_plan_free(some.plan), lt_plan_free(padded.plan);
    lt_graph_free(some.g), lt_graph_free(padded.g);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_test(c, rows_of_zeros);
}

int main(void)
{
    return run_suite("gaussians", add_tests);
}
