/* SPDX-License-Identifier: Apache-2.0 */
/* The point backbone's task: shapes and views, the loss by its formula, and short runs. */
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/geometry/mesh/surface.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "models/points/points.h"
#include "tasks/point_pairs/shapes.h"
#include "tasks/point_pairs/task.h"
#include "tests/scratch.h"
#include "train/trainer.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <signal.h>

static void setup(void)
{
    open_scratch();
}

/* ---- shapes ---- */

enum { SHAPES = 200, N = 256 };

/* Any shape can be looked at: finite, with area, its views within a quarter more than the unit sphere. */
START_TEST(shapes_have_views)
{
    static lt_real view[N][3];

    for (int i = 0; i < SHAPES; i++) {
        lt_rng rng = lt_rng_make(7, (uint64_t)i);
        double far = 0;
        lt_mesh mesh;

        check_ok(shape_draw(arena, &rng, &mesh));
        ck_assert(lt_mesh_area(&mesh) > 0.01);
        check_ok(shape_view(arena, &mesh, &rng, N, view));
        for (int p = 0; p < N; p++)
            far = fmax(far, hypot(hypot((double)view[p][0], (double)view[p][1]), (double)view[p][2]));
        ck_assert_msg(far > 0.2 && far < 1.25 + 0.1, "shape %d reaches to %g", i, far);
        lt_arena_reset(arena);
    }
}
END_TEST

/* The same numbers give the same view; other numbers another one. */
START_TEST(views_are_drawn)
{
    static lt_real view[3][N][3];
    lt_rng rng = lt_rng_make(7, 1);
    lt_mesh mesh;

    check_ok(shape_draw(arena, &rng, &mesh));
    for (int k = 0; k < 3; k++) {
        lt_rng of_view = lt_rng_make(8, k / 2);
        check_ok(shape_view(arena, &mesh, &of_view, N, view[k]));
    }
    ck_assert_mem_eq(view[0], view[1], sizeof(view[0]));
    ck_assert_mem_ne(view[0], view[2], sizeof(view[0]));
}
END_TEST

/* A ball's views are partial: the middle of their points is off the ball's, by up to half a radius. */
START_TEST(views_are_partial)
{
    enum { ROUND = 16, M = (ROUND + 1) * (2 * ROUND + 1) };
    static float vertex[M][3];
    static int32_t face[4 * ROUND * ROUND][3];
    static lt_real view[2048][3];
    const lt_mesh ball = { .n_vertices = M, .n_faces = 4 * ROUND * ROUND, .vertex = vertex, .face = face };
    double least = 1, most = 0;

    for (int i = 0; i < M; i++) {
        const double u = M_PI * (i / (2 * ROUND + 1)) / ROUND, v = M_PI * (i % (2 * ROUND + 1)) / ROUND;
        vertex[i][0] = (float)(sin(u) * cos(v));
        vertex[i][1] = (float)(sin(u) * sin(v));
        vertex[i][2] = (float)cos(u);
    }
    for (int i = 0, f = 0; i < ROUND; i++)
        for (int j = 0; j < 2 * ROUND; j++) {
            const int32_t a = i * (2 * ROUND + 1) + j, b = a + 2 * ROUND + 1;
            memcpy(face[f++], ((int32_t[]){ a, b, a + 1 }), sizeof(face[0]));
            memcpy(face[f++], ((int32_t[]){ b, b + 1, a + 1 }), sizeof(face[0]));
        }
    for (int i = 0; i < 40; i++) {
        lt_rng rng = lt_rng_make(9, (uint64_t)i);
        double middle[3] = { 0 };

        check_ok(shape_view(arena, &ball, &rng, 2048, view));
        for (int p = 0; p < 2048; p++)
            for (int k = 0; k < 3; k++)
                middle[k] += (double)view[p][k] / 2048;
        least = fmin(least, lt_vec3_norm(middle));
        most = fmax(most, lt_vec3_norm(middle));
    }
    ck_assert_msg(least < 0.1 && most > 0.4 && most < 0.65, "from %g to %g", least, most);
}
END_TEST

/* ---- the loss, by Chen et al.'s equation 1 ---- */

enum { B = 3, E = POINTS_EMBEDDING };

static double contrast(const lt_real *z, const lt_real *others, const lt_real *weight, double temperature)
{
    double sum = 0, all = 0;

    for (int i = 0; i < 2 * B; i++) {
        double below = 0, twin = 0;
        for (int j = 0; j < 2 * B; j++) {
            double s = 0;
            for (int k = 0; k < E; k++)
                s += (double)z[i * E + k] * z[j * E + k];
            twin = j == (i ^ 1) ? s / temperature : twin;
            below += others[i * 2 * B + j] < 0 ? 0 : exp(s / temperature);
        }
        sum += weight[i] * (log(below) - twin);
        all += weight[i];
    }
    return sum / all;
}

static lt_real *input(const lt_plan *p, const model_record *r, const char *name)
{
    return lt_plan_data(p, model_port_find(&r->inputs, name));
}

/* With three pairs, and with the last of them not there. */
START_TEST(loss_is_the_formula)
{
    cJSON *config = cJSON_Parse("{\"variant\": \"cpu\", \"temperature\": 0.2}");
    lt_params *set = lt_params_new();
    model_record r = { .g = lt_graph_new(), .batch = B };
    const int there = _i ? 2 * B - 2 : 2 * B;
    lt_rng rng = lt_rng_make(5, 0);
    lt_real *points, *others, *weight;
    lt_plan *plan;
    model m;

    check_ok(model_create(&points_class, "test", config, NULL, set, &m));
    points_class.init(&m, 1);
    points_class.record(&m, true, &r);
    plan = lt_compile(r.g, &(lt_compile_opts){ 0 });
    ck_assert_msg(plan != NULL, "%s", lt_last_error());
    points = input(plan, &r, "points");
    others = input(plan, &r, "others");
    weight = input(plan, &r, "weight");
    for (int i = 0; i < 2 * B * points_view(&m) * 3; i++)
        points[i] = (lt_real)lt_rng_range(&rng, -0.6, 0.6) * (lt_real)(1 + i / (points_view(&m) * 3)) / 6;
    for (int i = 0; i < 4 * B * B; i++)
        others[i] = i / (2 * B) == i % (2 * B) || i % (2 * B) >= there ? (lt_real)-1e4 : 0;
    for (int i = 0; i < 2 * B; i++)
        weight[i] = i < there;
    lt_run(plan);
    {
        const lt_real *z = lt_plan_data(plan, model_port_find(&r.outputs, "embedding"));
        const lt_real *loss = lt_plan_data(plan, r.loss);
        double length = 0;

        for (int k = 0; k < E; k++)
            length += (double)z[k] * z[k];
        ck_assert_double_eq_tol(length, 1, 1e-5);
        ck_assert_double_eq_tol(*loss, contrast(z, others, weight, 0.2), 2e-5);
    }
    lt_plan_free(plan);
    lt_graph_free(r.g);
    lt_params_free(set);
    cJSON_Delete(config);
}
END_TEST

/* ---- runs ---- */

static const task *const tasks[] = { &point_pairs_task, NULL };

static train_options options(const char *out)
{
    static const char config[] = "{ \"model\": { \"name\": \"points\", \"variant\": \"cpu\" }, "
        "\"data\": { \"threads\": 2, \"shapes\": 3, \"held_out\": 5 }, \"optim\": { \"kind\": \"adamw\", \"batch\": 7, "
        "\"steps\": 6 }, \"train\": { \"validate_steps\": 6, \"validate_every\": 0, \"checkpoint_minutes\": 0 } }";

    check_ok(lt_write_file(at("points.json"), config, sizeof(config) - 1));
    return (train_options){ .tasks = tasks, .config = at("points.json"), .out = at(out), .quiet = true };
}

/* 24 shapes in batches of 7, so that the last of an epoch has places without a sample. */
START_TEST(threads_do_not_matter)
{
    for (int threads = 1; threads <= 2; threads++) {
        const train_options o = options(threads == 1 ? "one" : "two");
        train_result r;

        lt_set_threads(threads);
        check_ok(train_run(&o, &r));
        ck_assert(r.best >= 0 && r.best <= 1);
    }
    same_end("one", "two");
}
END_TEST

static void stop_at_4(void *ctx, int64_t step, lt_params *params)
{
    (void)ctx, (void)params;
    if (step == 4)
        raise(SIGTERM);
}

START_TEST(stops_do_not_matter)
{
    train_options o = options("whole");

    check_ok(train_run(&o, NULL));
    o.out = at("stopped");
    o.before_step = stop_at_4;
    ck_assert_int_eq(train_run(&o, NULL), LT_ESTOPPED);
    o.config = NULL;
    o.resume = "";
    o.before_step = NULL;
    check_ok(train_run(&o, NULL));
    same_end("whole", "stopped");
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, setup, close_scratch);
    tcase_set_timeout(c, 0);
    tcase_add_test(c, shapes_have_views);
    tcase_add_test(c, views_are_drawn);
    tcase_add_test(c, views_are_partial);
    tcase_add_loop_test(c, loss_is_the_formula, 0, 2);
    tcase_add_test(c, threads_do_not_matter);
    tcase_add_test(c, stops_do_not_matter);
}

int main(void)
{
    return run_suite("point_pairs", add_tests);
}
