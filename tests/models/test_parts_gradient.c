/* SPDX-License-Identifier: Apache-2.0 */
/* ViT, LPIPS and reid's units in double: slopes along random directions against differences. */
#include "libtensor/base/rng.h"
#include "libtensor/graph/plan.h"
#include "libtensor/nn/init.h"
#include "models/backbones/lpips.h"
#include "models/backbones/vit.h"
#include "models/reid/unit.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

static lt_params *params;
static lt_graph *g;
static lt_plan *plan;

static void start(void)
{
    params = lt_params_new();
    g = lt_graph_new();
}

static void stop(void)
{
    lt_plan_free(plan);
    lt_graph_free(g);
    lt_params_free(params);
}

static void fill(lt_tensor *t, lt_rng *r)
{
    lt_real *x = lt_plan_data(plan, t);

    for (int64_t i = 0; i < lt_numel(t); i++)
        x[i] = lt_rng_uniform(r);
}

static void compile(lt_tensor *loss)
{
    lt_output(loss, "loss");
    plan = lt_compile(g, &(lt_compile_opts){ .train = true, .loss = loss });
    ck_assert_msg(plan != NULL, "%s", lt_last_error());
}

/* The loss's slope along a direction of n numbers x, whose gradient is in dx, against its differences */
static void expect_slope(const char *what, lt_tensor *loss, lt_real *x, const lt_real *dx, int64_t n, double step)
{
    lt_real *direction = lt_alloc((size_t)n * sizeof(*direction)), *at = lt_alloc((size_t)n * sizeof(*at));
    lt_rng r = lt_rng_make(7, (uint64_t)n);
    double slope = 0, f[2];

    memcpy(at, x, (size_t)n * sizeof(*at));
    for (int64_t i = 0; i < n; i++) {
        direction[i] = lt_rng_normal(&r);
        slope += direction[i] * dx[i];
    }
    for (int k = 0; k < 2; k++) {
        for (int64_t i = 0; i < n; i++)
            x[i] = at[i] + (k ? -step : step) * direction[i];
        lt_params_changed(params);
        lt_run(plan);
        f[k] = *(lt_real *)lt_plan_data(plan, loss);
    }
    memcpy(x, at, (size_t)n * sizeof(*at));
    f[0] = (f[0] - f[1]) / (2 * step);
    ck_assert_msg(fabs(f[0] - slope) < 1e-6 * fmax(fabs(slope), 1e-3), "%s: slope %.12g, differences %.12g", what,
                  slope, f[0]);
    lt_release(direction);
    lt_release(at);
}

START_TEST(vit_slopes)
{
    const vit_opts small = { .image_size = 12, .patch = 4, .width = 8, .layers = 2, .heads = 2 };
    const int64_t shape[] = { 2, 3, 12, 12 };
    lt_rng r = lt_rng_make(3, 0);
    lt_tensor *image = lt_want_grad(lt_input(g, "image", LT_F32, 4, shape)), *loss;
    vit m;
    vit_out y;

    vit_new(&m, params, "vit", &small);
    lt_init_default(params, 3);
    vit_init(&m, 3);
    for (lt_param *p = lt_params_first(params); p; p = p->next)     /* where nothing is small or alike */
        for (int64_t i = 0; i < lt_param_numel(p); i++)
            p->data[i] += 0.3 * lt_rng_normal(&r);
    y = vit_forward(&m, vit_normalise(image));
    loss = lt_add(lt_sum(lt_mul(y.feature, y.feature)), lt_sum(lt_mul(y.patches, lt_sigmoid(y.patches))));
    compile(loss);
    fill(image, &r);
    lt_run(plan);
    expect_slope("image", loss, lt_plan_data(plan, image), lt_plan_grad(plan, image), lt_numel(image), 1e-6);
    for (lt_param *p = lt_params_first(params); p; p = p->next) {
        lt_real *grad = lt_alloc((size_t)lt_param_numel(p) * sizeof(*grad));

        lt_params_zero_grad(params);
        lt_run(plan);
        memcpy(grad, p->grad, (size_t)lt_param_numel(p) * sizeof(*grad));
        expect_slope(p->name, loss, p->data, grad, lt_param_numel(p), 1e-6);
        lt_release(grad);
    }
}
END_TEST

/* Steps are so small that hardly a relu or a maximum changes its mind. */
START_TEST(lpips_slopes)
{
    const int64_t shape[] = { 2, 3, 40, 47 }, four[] = { 2, 4 };
    const lt_real the_boxes[] = { 2, 3, 44, 38, 5, 1, 39, 36 };
    lt_rng r = lt_rng_make(4, 0);
    lt_tensor *image = lt_want_grad(lt_input(g, "image", LT_F32, 4, shape));
    lt_tensor *truth = lt_input(g, "truth", LT_F32, 4, shape);
    lt_tensor *boxes = lt_input(g, "boxes", LT_F32, 2, four), *loss;
    lt_real *grad;
    lpips m;

    lpips_new(&m, params, "lpips");
    lpips_init(&m);
    loss = lt_sum(lt_scale(lpips_distance(&m, LPIPS_SYM, image, truth, boxes), 100));
    compile(loss);
    fill(image, &r);
    fill(truth, &r);
    memcpy(lt_plan_data(plan, boxes), the_boxes, sizeof(the_boxes));
    lt_run(plan);
    grad = lt_alloc((size_t)lt_numel(image) * sizeof(*grad));
    memcpy(grad, lt_plan_grad(plan, image), (size_t)lt_numel(image) * sizeof(*grad));
    expect_slope("image", loss, lt_plan_data(plan, image), grad, lt_numel(image), 1e-7);
    lt_release(grad);
}
END_TEST

/* One unit that keeps the map and one that halves it, as ours and as TensorFlow pad it */
START_TEST(reid_slopes)
{
    const int64_t shape[] = { 3, 4, 6, 4 };
    lt_rng r = lt_rng_make(5, 0);
    lt_tensor *image = lt_want_grad(lt_input(g, "image", LT_F32, 4, shape)), *x, *loss;
    const reid_unit keeps = reid_unit_new(params, "a", 4, 4, true, 0, _i);
    const reid_unit halves = reid_unit_new(params, "b", 4, 8, false, 0, _i);

    lt_init_default(params, 5);
    x = reid_unit_forward(&halves, reid_unit_forward(&keeps, image));
    loss = lt_sum(lt_mul(x, lt_sigmoid(x)));
    compile(loss);
    fill(image, &r);
    lt_run(plan);
    expect_slope("image", loss, lt_plan_data(plan, image), lt_plan_grad(plan, image), lt_numel(image), 1e-6);
    for (lt_param *p = lt_params_first(params); p; p = p->next) {
        lt_real grad[1024];

        if (p->kind != LT_WEIGHT)
            continue;
        lt_params_zero_grad(params);
        lt_run(plan);
        memcpy(grad, p->grad, (size_t)lt_param_numel(p) * sizeof(*grad));
        expect_slope(p->name, loss, p->data, grad, lt_param_numel(p), 1e-6);
    }
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_set_timeout(t, 120);
    tcase_add_checked_fixture(t, start, stop);
    tcase_add_test(t, vit_slopes);
    tcase_add_test(t, lpips_slopes);
    tcase_add_loop_test(t, reid_slopes, 0, 2);
}

int main(void)
{
    return run_suite("gradients of parts", add_tests);
}
