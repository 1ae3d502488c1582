/* SPDX-License-Identifier: Apache-2.0 */
/* What the op suite of splat_raster does not see: lists that overflow, a crowd in one tile, sums of images. */
#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"
#include "libtensor/graph/plan.h"
#include "libtensor/ops/ops.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { SIDE = 100, CHANNELS = 12, INPUTS = 4, BLANKET = 60, HIDDEN = 4000 };

/* n Gaussians, drawn with images of both sets; with gradients of all inputs to a loss of random weights */
typedef struct {
    lt_graph *g;
    lt_plan *plan;
    lt_tensor *in[INPUTS], *image, *instances;
    int64_t n;
} picture;

static const int64_t width_of[INPUTS] = { 3, 9, 1, 3 };

static picture picture_new(int64_t n, int64_t side, int32_t first, bool white, bool train)
{
    static const lt_real camera[4] = { 100, 100, 50, 50 };
    picture p = { .g = lt_graph_new(), .n = n };
    const lt_shape shape[INPUTS] = { LT_SHAPE(n, 3), LT_SHAPE(n, 3, 3), LT_SHAPE(n), LT_SHAPE(n, 3) };
    lt_tensor *weight, *loss;

    for (int i = 0; i < INPUTS; i++) {
        p.in[i] = lt_input(p.g, "in", LT_F32, shape[i].rank, shape[i].dim);
        if (train)
            lt_want_grad(p.in[i]);
    }
    p.image = lt_splat_raster(&(lt_splat_in){ p.in[0], p.in[1], p.in[2], p.in[3],
                                              lt_constant(p.g, LT_F32, LT_SHAPE(4), camera), NULL,
                                              lt_constant(p.g, LT_I32, (lt_shape){ 0 }, &first) },
                              &(lt_splat_opts){ .width = side, .height = side, .near_z = 0.2, .white = white,
                                                .sets = true });
    p.instances = lt_output(lt_result(p.image, 2), "instances");
    lt_output(p.image, "image");
    weight = lt_input(p.g, "weight", LT_F32, 3, p.image->shape.dim);
    loss = lt_output(lt_sum(lt_mul(p.image, weight)), "loss");
    p.plan = lt_compile(p.g, &(lt_compile_opts){ .train = train, .loss = train ? loss : NULL });
    ck_assert_msg(p.plan != NULL, "%s", lt_last_error());
    for (int64_t i = 0; train && i < lt_numel(weight); i++)
        ((lt_real *)lt_plan_data(p.plan, weight))[i] = (lt_real)(i % 17 - 8) / 8;
    return p;
}

static void picture_free(picture *p)
{
    lt_plan_free(p->plan);
    lt_graph_free(p->g);
}

static lt_real *data(const picture *p, int input)
{
    return lt_plan_data(p->plan, p->in[input]);
}

/* The first `many` as large as the image, one behind the other; the others behind the camera */
static void spread(const picture *p, int64_t many, double size)
{
    lt_rng r = lt_rng_make(5, 0);

    for (int64_t i = 0; i < p->n; i++) {
        for (int k = 0; k < 3; k++) {
            data(p, 0)[3 * i + k] = (lt_real)lt_rng_range(&r, -.3, .3);
            data(p, 3)[3 * i + k] = (lt_real)lt_rng_uniform(&r);
        }
        for (int k = 0; k < 9; k++)
            data(p, 1)[9 * i + k] = (lt_real)(size * lt_rng_range(&r, -1, 1));
        data(p, 0)[3 * i + 2] = (lt_real)(i < many ? lt_rng_range(&r, 1, 2) : -1);
        data(p, 2)[i] = (lt_real)lt_rng_range(&r, .05, .2);
    }
}

static void expect_same(const lt_real *a, const lt_real *b, int64_t n, const char *what)
{
    ck_assert_msg(memcmp(a, b, (size_t)n * sizeof(*a)) == 0, "%s: other bits", what);
}

/* Rows that are not drawn make room in the lists: with them all instances fit, without they overflow many times. */
START_TEST(overflow)
{
    picture tight = picture_new(BLANKET, SIDE, BLANKET / 3, _i % 2, true);
    picture roomy = picture_new(BLANKET + HIDDEN, SIDE, BLANKET / 3, _i % 2, true);

    lt_set_threads(1 + _i / 2);
    spread(&tight, BLANKET, .4);
    spread(&roomy, BLANKET, .4);
    for (int i = 0; i < INPUTS; i++)
        memcpy(data(&roomy, i), data(&tight, i), (size_t)(BLANKET * width_of[i]) * sizeof(lt_real));
    lt_run(tight.plan);
    lt_run(roomy.plan);
    ck_assert_double_gt((double)*(lt_real *)lt_plan_data(tight.plan, tight.instances), 4 * (8 * BLANKET + 49));
    expect_same(lt_plan_data(tight.plan, tight.image), lt_plan_data(roomy.plan, roomy.image), lt_numel(tight.image),
                "image");
    for (int i = 0; i < INPUTS; i++)
        expect_same(lt_plan_grad(tight.plan, tight.in[i]), lt_plan_grad(roomy.plan, roomy.in[i]),
                    BLANKET * width_of[i], "gradient");
    lt_set_threads(0);
    picture_free(&tight);
    picture_free(&roomy);
}
END_TEST

/* A million in one tile, without a size or with a large one: the nearest ones are what is seen. */
START_TEST(crowd)
{
    picture p = picture_new(1000000, 16, 0, false, false);
    const lt_real *image;

    spread(&p, p.n, 0);
    for (int64_t i = 0; i < p.n; i++) {
        data(&p, 0)[3 * i] = data(&p, 0)[3 * i + 1] = (lt_real)-.45 * data(&p, 0)[3 * i + 2];
        data(&p, 1)[9 * i] = data(&p, 1)[9 * i + 4] = (lt_real)(_i ? 1 : 0);
        data(&p, 2)[i] = (lt_real).5;
        data(&p, 3)[3 * i] = 1, data(&p, 3)[3 * i + 1] = 0, data(&p, 3)[3 * i + 2] = (lt_real).5;
    }
    lt_run(p.plan);
    image = lt_plan_data(p.plan, p.image);
    ck_assert_double_eq((double)*(lt_real *)lt_plan_data(p.plan, p.instances), 1e6);
    ck_assert_double_eq_tol((double)image[5 * 16 + 5], 1, 1e-3);
    ck_assert_double_eq((double)image[256 + 5 * 16 + 5], 0);
    ck_assert_double_eq_tol((double)image[512 + 5 * 16 + 5], .5, 1e-3);
    picture_free(&p);
}
END_TEST

/* On black: both sets' images add up to the image. On white: with the white that stands in both once too often. */
START_TEST(sums)
{
    picture p = picture_new(500, SIDE, 200, _i, false);
    const int64_t plane = SIDE * SIDE;
    const lt_real *image;

    spread(&p, 450, .05);
    lt_run(p.plan);
    image = lt_plan_data(p.plan, p.image);
    for (int64_t i = 0; i < plane; i++) {
        const double all = (double)image[9 * plane + i];

        ck_assert_double_eq_tol((double)image[10 * plane + i] + (double)image[11 * plane + i], all, 1e-6);
        for (int k = 0; k < 3; k++)
            ck_assert_double_eq_tol((double)image[(3 + k) * plane + i] + (double)image[(6 + k) * plane + i],
                                    (double)image[k * plane + i] + (_i ? 1 : 0), 2e-6);
    }
    picture_free(&p);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 60);
    tcase_add_loop_test(tc, overflow, 0, 8);
    tcase_add_loop_test(tc, crowd, 0, 2);
    tcase_add_loop_test(tc, sums, 0, 2);
}

int main(void)
{
    return run_suite("splat", add_tests);
}
