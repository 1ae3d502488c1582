/* SPDX-License-Identifier: Apache-2.0 */
/* Learning whole bodies from a few pictures, made as `palmar synth --preset body` makes them: the set itself, what the
 * model is compared with, bits that do not depend on threads or stops, scores by hand. */
#include "assets/run_body.h"
#include "libtensor/base/parallel.h"
#include "libtensor/geometry/rotation.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "synth/generate.h"
#include "tasks/body/config.h"
#include "tasks/body/scores.h"
#include "tasks/body/target.h"
#include "tasks/body/task.h"
#include "tasks/body/truth.h"
#include "tests/scratch.h"
#include "train/trainer.h"

#include <math.h>
#include <signal.h>

enum { PICTURES = 10, EVALUATION = 2 };

static const task *const tasks[] = { &body_task, NULL };

/* One set for all tests */
static void setup(void)
{
    static const char config[] = "{ \"model\": { \"name\": \"osx\" }, \"optim\": { \"kind\": \"adam\", \"lr\": 1e-4, "
        "\"schedule\": \"constant\", \"batch\": 2, \"shards\": 2, \"steps\": 2 }, \"train\": { "
        "\"checkpoint_minutes\": 0, \"validate_every\": 0, \"validate_samples\": 2 } }";

    open_scratch();
    check_ok(synth_generate(&(synth_options){ .preset = SYNTH_BODY, .out = at("data"), .seed = 4, .frames = PICTURES },
                            NULL, NULL));
    check_ok(lt_write_file(at("body.json"), config, sizeof(config) - 1));
}

static void open_set(const char *split, body_set *set)
{
    check_ok(body_set_open(arena, at("data"), split, set));
}

/* ---- the set ---- */

START_TEST(the_set)
{
    body_set train, evaluation;
    lt_image picture;
    run_body body;

    ck_assert(body_set_probe(at("data")));
    open_set("train", &train);
    open_set("evaluation", &evaluation);
    ck_assert(train.n == PICTURES - EVALUATION && evaluation.n == EVALUATION && train.synthetic);
    for (int i = 0; i < EVALUATION; i++)                /* nobody is in both */
        for (int k = 0; k < train.n; k++)
            ck_assert_int_ne(evaluation.row[i].subject, train.row[k].subject);
    check_ok(body_set_picture(&train, train.n - 1, arena, &picture));
    check_ok(run_body_open(arena, body_set_body(arena, at("data")), &body));
    check_ok(body_truth_check(&body, &train));
    body.model->v_template[5361][1] += 0.02f;           /* a finger tip */
    check_error(body_truth_check(&body, &train), LT_EINVAL, "its poses were made with another body");
}
END_TEST

/* A rotation of the model's order in the body's, and where the virtual camera sees a node */
START_TEST(targets)
{
    const person_window window = { .scale = 2, .shift = { -30, -50 } };
    body_target t;
    body_set set;
    const body_row *row;
    double jaw[9];

    open_set("train", &set);
    row = &set.row[0];
    body_target_make(row, &window, &t);
    lt_rot_from_axis_angle((double[]){ row->pose[BODY_JAW][0], row->pose[BODY_JAW][1], row->pose[BODY_JAW][2] }, jaw);
    for (int k = 0; k < 9; k++)
        ck_assert_double_eq_tol(t.rotation[52][k], jaw[k], 1e-6);
    ck_assert_double_eq_tol(t.body_place[7][0], (2 * row->nodes_2d[7][0] - 30) / 16, 1e-4);
    ck_assert_double_eq_tol(t.body_place[7][2], 8 * (1 + row->nodes_3d[7][2] - row->nodes_3d[0][2]), 1e-4);
    ck_assert_double_eq_tol(t.hand_place[20][2], 8 * (1 + (row->nodes_3d[45][2] - row->nodes_3d[13][2]) / 0.15), 1e-4);
    ck_assert_double_eq_tol(t.box_size[2][1], 2 * (row->boxes[2][3] - row->boxes[2][1]) / 16, 1e-4);
    ck_assert_double_eq_tol(t.bearing[0][1], (2 * row->nodes_2d[0][1] - 50 - 128) / 16,
                            3e-3 * fabs((double)t.bearing[0][1]) + 1e-4);
}
END_TEST

/* In a mirror the body is another that its model can be: posed so, its nodes are where the mirror shows them. */
START_TEST(mirrored)
{
    double (*vertices)[3] = lt_arena_array(arena, BODY_VERTICES, sizeof(*vertices)), nodes[BODY_NODES][3];
    body_row row, back;
    run_body body;
    body_set set;

    open_set("train", &set);
    check_ok(run_body_open(arena, body_set_body(arena, at("data")), &body));
    for (int i = 0; i < 3; i++) {
        row = set.row[i];
        body_row_mirror(&row, 192);
        ck_assert_float_eq_tol(row.nodes_2d[12][0], 191 - set.row[i].nodes_2d[13][0], 1e-4f);
        ck_assert_int_eq(row.holds[0], set.row[i].holds[1]);
        memset(row.expression, 0, sizeof(row.expression));
        body_truth(body.model, &row, vertices, nodes);
        for (int k = 0; k < 20; k++)            /* but the face, whose expression is another one's here */
            for (int a = 0; a < 3; a++)
                ck_assert_double_eq_tol(nodes[k][a], (double)row.nodes_3d[k][a], 1e-3);
        for (int k = 25; k < BODY_NODES; k++)
            for (int a = 0; a < 3; a++)
                ck_assert_double_eq_tol(nodes[k][a], (double)row.nodes_3d[k][a], 1e-3);
        back = set.row[i];
        body_row_mirror(&back, 192);
        body_row_mirror(&back, 192);
        for (int k = 0; k < BODY_NODES; k++)
            ck_assert_float_eq_tol(back.nodes_2d[k][0], set.row[i].nodes_2d[k][0], 1e-4f);
        ck_assert_mem_eq(back.pose[1], set.row[i].pose[1], sizeof(back.pose[1]));
    }
}
END_TEST

/* By a quarter of a circle: what lay to the right lies below, and the whole body with it. */
START_TEST(turned)
{
    const person_window window = { .scale = 1, .turn = M_PI / 2, .shift = { 200, 0 } };
    const body_row *row;
    body_target t;
    body_set set;

    open_set("train", &set);
    row = &set.row[0];
    body_target_make(row, &window, &t);
    ck_assert_double_eq_tol(t.nodes[5][0], row->nodes_3d[0][1] - row->nodes_3d[5][1], 1e-6);
    ck_assert_double_eq_tol(t.nodes[5][1], row->nodes_3d[5][0] - row->nodes_3d[0][0], 1e-6);
    ck_assert_double_eq_tol(t.body_place[7][0], (200 - row->nodes_2d[7][1]) / 16, 1e-4);
    ck_assert_double_eq_tol(t.body_place[7][1], row->nodes_2d[7][0] / 16, 1e-4);
    ck_assert_double_eq_tol(t.box_size[2][0], (row->boxes[2][3] - row->boxes[2][1]) / 16, 1e-4);
}
END_TEST

START_TEST(errors)
{
    double nodes[BODY_NODES][3], moved[BODY_NODES][3];
    body_errors e;
    body_set set;

    open_set("train", &set);
    for (int i = 0; i < BODY_NODES; i++)
        for (int k = 0; k < 3; k++) {
            nodes[i][k] = set.row[0].nodes_3d[i][k];
            moved[i][k] = nodes[i][k] + 0.5;
        }
    for (int i = 25; i < 45; i++)
        moved[i][1] += 0.02;                            /* the left hand, from its wrist */
    moved[24][0] += 0.05;                               /* the nose */
    body_errors_of((const double (*)[3])moved, (const double (*)[3])nodes, NULL, NULL, &e);
    ck_assert_double_eq_tol(e.mm[BODY_MPJPE], 50.0 / 25, 1e-9);
    ck_assert_double_eq_tol(e.mm[BODY_HAND_MPJPE], 10, 1e-9);
    ck_assert(e.mm[BODY_PA_MPJPE] > 0 && e.mm[BODY_PA_MPJPE] < 6 && isnan(e.mm[BODY_PVE]));
}
END_TEST

/* ---- learning ---- */

static lt_status train(const char *out, const char *more, const char *resume,
                       void (*before_step)(void *, int64_t, lt_params *), train_result *result)
{
    const char *set[] = { lt_arena_printf(arena, "data.dir=%s/data", scratch_folder),
                          lt_arena_printf(arena, "data.body=%s/data/body.npz", scratch_folder), more };
    train_options o = { .tasks = tasks, .config = resume ? NULL : at("body.json"), .out = at(out), .quiet = true,
                        .resume = resume, .before_step = before_step, .set = set, .n_set = resume ? 0 : more ? 3 : 2 };

    return train_run(&o, result);
}

static void stop_at_second(void *ctx, int64_t step, lt_params *set)
{
    (void)ctx, (void)set;
    if (step == 1)
        raise(SIGTERM);
}

START_TEST(threads_and_stops_do_not_matter)
{
    train_result r;

    lt_set_threads(1);
    check_ok(train("whole", "train.validate_steps=2", NULL, NULL, &r));
    ck_assert(r.best > 10 && r.best < 2000);            /* mm, of a network that knows nothing */
    lt_set_threads(4);
    ck_assert_int_eq(train("stopped", "train.validate_steps=2", NULL, stop_at_second, NULL), LT_ESTOPPED);
    check_ok(train("stopped", NULL, "", NULL, NULL));
    same_end("whole", "stopped");
}
END_TEST

/* The layers that turn all joints at once have a rate of their own, and the transformer's matrices; Muon is for these. */
START_TEST(rates)
{
    const char *set[] = { "data.heads_rate=0.5", "data.matrices_rate=3", "optim.min_lr=1e-6", "optim.kind=muon" };
    lt_optim_group group[BODY_GROUPS];
    train_config c;

    check_ok(train_config_load(arena, tasks, at("body.json"), set, LT_COUNT(set), &c));
    body_groups(&c, group);
    ck_assert_double_eq_tol(group[0].schedule.lr, 0.5e-4, 1e-12);
    ck_assert_double_eq_tol(group[0].schedule.min_lr, 0.5e-6, 1e-12);
    ck_assert_str_eq(group[0].prefix[0], "body_regressor.root_pose_out.");
    ck_assert(group[0].kind == LT_ADAMW);
    ck_assert_double_eq_tol(group[1].schedule.lr, 3e-4, 1e-12);
    ck_assert(group[1].kind == LT_MUON);
    ck_assert_str_eq(group[1].prefix[0], "encoder.blocks.");
    ck_assert_double_eq_tol(group[2].schedule.lr, 1e-4, 1e-12);
    ck_assert(!group[2].prefix && group[2].kind == LT_ADAMW && group[2].schedule.kind == LT_CONSTANT_LR);
    train_config_fini(&c);
    check_ok(train_config_load(arena, tasks, at("body.json"), NULL, 0, &c));
    body_groups(&c, group);
    ck_assert(group[0].kind == LT_ADAM && group[1].kind == LT_ADAM && group[2].kind == LT_ADAM);
    train_config_fini(&c);
}
END_TEST

START_TEST(refused)
{
    lt_arena *own = lt_arena_new();
    run_body body;

    check_error(run_body_open(own, at("none.npz"), &body), LT_EIO,
                "none.npz: no such file; SMPLX_NEUTRAL.npz is offered");
    check_error(run_body_open(own, at("data/train.npz"), &body), LT_EFORMAT, "data/train.npz: ");
    check_error(train("side", "data.body=none", NULL, NULL, NULL), LT_EIO, "none: no such file");
    lt_arena_free(own);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 300);
    tcase_add_unchecked_fixture(tc, setup, close_scratch);
    tcase_add_test(tc, the_set);
    tcase_add_test(tc, targets);
    tcase_add_test(tc, mirrored);
    tcase_add_test(tc, turned);
    tcase_add_test(tc, errors);
    tcase_add_test(tc, threads_and_stops_do_not_matter);
    tcase_add_test(tc, rates);
    tcase_add_test(tc, refused);
}

int main(void)
{
    return run_suite("body", add_tests);
}
