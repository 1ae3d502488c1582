/* SPDX-License-Identifier: Apache-2.0 */
/* The body that an osx makes, in double: slopes of its two losses along random directions against differences, and the
 * bearings of points against their places in the picture. */
#include "libtensor/base/rng.h"
#include "libtensor/graph/plan.h"
#include "models/body/osx_losses.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { B = 2, V = 30, J = OSX_RIG_JOINTS, S = 20, P = 9 * (J - 1), INPUTS = 4 };

static lt_arena *arena;
static lt_graph *g;
static lt_plan *plan;
static model_record r;

static float *random_floats(int64_t n, double size, lt_rng *rng)
{
    float *x = lt_arena_array(arena, (size_t)n, sizeof(*x));

    for (int64_t i = 0; i < n; i++)
        x[i] = (float)(size * lt_rng_normal(rng));
    return x;
}

/* A bush of joints with a few vertices, which every joint moves a little */
static lt_skin_layer *small_body(void)
{
    static int parents[J], points[OSX_NODES];
    lt_rng rng = lt_rng_make(3, 0);
    lt_skin_layer *layer;
    lt_rig rig = { .V = V, .J = J, .S = S, .parents = parents };

    for (int j = 0; j < J; j++)
        parents[j] = j ? (j - 1) / 2 : -1;
    for (int i = 0; i < OSX_NODES; i++)
        points[i] = i < 40 ? i : J + i - 40;
    rig.v_template = random_floats(V * 3, 0.3, &rng);
    rig.shapedirs = random_floats(V * 3 * S, 0.02, &rng);
    rig.posedirs = random_floats(V * 3 * P, 0.01, &rng);
    rig.J_regressor = random_floats(J * V, 0.2, &rng);
    rig.weights = random_floats(V * J, 0.2, &rng);
    check_ok(lt_skin_layer_new(arena, &rig, points, OSX_NODES, &layer));
    return layer;
}

static const struct {
    const char *name;
    int rank;
    int64_t shape[4];
} inputs[INPUTS] = {
    { "rotation", 4, { B, 53, 3, 3 } }, { "shape", 2, { B, 10 } }, { "expression", 2, { B, 10 } },
    { "camera", 2, { B, 3 } },
};

/* What an osx gives are inputs here. */
static void start(void)
{
    lt_rng rng = lt_rng_make(5, 0);

    arena = lt_arena_new();
    g = lt_graph_new();
    r = (model_record){ .g = g, .batch = B };
    for (int i = 0; i < INPUTS; i++)
        model_port_add(&r.outputs, inputs[i].name,
                       lt_want_grad(lt_input(g, inputs[i].name, LT_F32, inputs[i].rank, inputs[i].shape)));
    model_input(&r, "weight", LT_SHAPE(B));
    osx_skin(small_body(), &(osx_weights){ .rotation = 1, .nodes = 3 }, &r);
    plan = lt_compile(g, &(lt_compile_opts){ .train = true, .loss = r.loss });
    ck_assert_msg(plan != NULL, "%s", lt_last_error());
    for (int i = 0; i < INPUTS; i++) {
        lt_real *x = lt_plan_data(plan, r.outputs.port[i].tensor);
        const int64_t n = lt_numel(r.outputs.port[i].tensor);

        for (int64_t k = 0; k < n; k++)
            x[k] = lt_rng_normal(&rng) + (i == INPUTS - 1 && k % 3 == 2 ? 20 : 0);      /* a camera from some way off */
    }
    for (int i = 0; i < r.inputs.n; i++) {
        lt_real *x = lt_plan_data(plan, r.inputs.port[i].tensor);

        for (int64_t k = 0; k < lt_numel(r.inputs.port[i].tensor); k++)
            x[k] = strcmp(r.inputs.port[i].name, "node_known") == 0 ? k % 3 > 0 : lt_rng_uniform(&rng);
    }
}

static void stop(void)
{
    lt_plan_free(plan);
    lt_graph_free(g);
    lt_arena_free(arena);
}

static double loss(void)
{
    lt_run(plan);
    return *(const lt_real *)lt_plan_data(plan, r.loss);
}

START_TEST(slopes)
{
    const double step = 1e-7;
    lt_tensor *t = r.outputs.port[_i].tensor;
    lt_real *x = lt_plan_data(plan, t);
    const int64_t n = lt_numel(t);
    lt_rng rng = lt_rng_make(7, (uint64_t)_i);
    double slope = 0, difference, *d = lt_arena_array(arena, (size_t)n, sizeof(*d));

    lt_run(plan);
    for (int64_t i = 0; i < n; i++) {
        d[i] = lt_rng_normal(&rng);
        slope += d[i] * ((const lt_real *)lt_plan_grad(plan, t))[i];
        x[i] += step * d[i];
    }
    difference = loss();
    for (int64_t i = 0; i < n; i++)
        x[i] -= 2 * step * d[i];
    difference = (difference - loss()) / (2 * step);
    ck_assert(fabs(slope) > 1e-3);
    ck_assert_msg(fabs(difference - slope) < 1e-6 * fabs(slope), "%s: slope %.12g, differences %.12g", inputs[_i].name,
                  slope, difference);
}
END_TEST

/* 40 pixels beside the middle are 2.5 cells. */
START_TEST(bearings)
{
    double at[2];

    osx_bearing((double[]){ 0.16, -0.32, 20 }, at);
    ck_assert_double_eq_tol(at[0], 2.5, 2.5 * 2e-3);
    ck_assert_double_eq_tol(at[1], -5, 5 * 2e-3);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_loop_test(tc, slopes, 0, INPUTS);
    tcase_add_test(tc, bearings);
}

int main(void)
{
    return run_suite("osx gradient", add_tests);
}
