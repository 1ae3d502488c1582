/* SPDX-License-Identifier: Apache-2.0 */
/* Groups of weights with recipes of their own against PyTorch's optimisers: rates, decay, clipping, warm-up, phases,
 * averages; what makes no group; their state. */
#include "libtensor/graph/plan.h"
#include "libtensor/nn/layers.h"
#include "libtensor/optim/optim.h"
#include "tests/optim/optim_vectors.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { N = 5, STEPS = 6, WEIGHTS = 3 };

static lt_params *set;
static lt_param *w[WEIGHTS];

static void add_weights(const char *const *name, int first_rank)
{
    for (int k = 0; k < WEIGHTS; k++) {
        w[k] = lt_params_add(set, "", name[k], LT_WEIGHT, k == first_rank ? LT_SHAPE(N, 1) : LT_SHAPE(N));
        ck_assert(lt_param_need_grad(w[k]));
        for (int i = 0; i < N; i++)
            w[k]->data[i] = (lt_real)(i - 2) / 4;
    }
}

static void start(void)
{
    set = lt_params_new();
    check_ok(lt_kernels_init());
}

static void stop(void)
{
    lt_params_free(set);
}

/* The same formula as in scripts/vectors/optim.py. */
static void set_gradients(int step)
{
    for (int k = 0; k < WEIGHTS; k++)
        for (int i = 0; i < N; i++)
            w[k]->grad[i] = (lt_real)((i + 1) * (w[k]->data[i] - 0.25) + sin((i + 1.0) * step + k) / 8);
}

static void take_step(lt_optim *o, int step, uint64_t groups, double epoch)
{
    set_gradients(step);
    ck_assert(isfinite(lt_optim_groups_norm(o, groups)));
    lt_optim_step_groups(o, &(lt_optim_now){ .groups = groups, .step = step - 1, .epoch = epoch });
}

static void check_weights(const double *want, double tol)
{
    for (int k = 0; k < WEIGHTS; k++)
        for (int i = 0; i < N; i++)
            ck_assert_msg(fabs((double)w[k]->data[i] - want[k * N + i]) < tol, "%s[%d] is %.9g, want %.9g", w[k]->name,
                          i, (double)w[k]->data[i], want[k * N + i]);
}

static const char *const names[] = { "net.a.weight", "net.b.weight", "points.place" };
static const char *const in_a[] = { "net.a.", NULL }, *const in_net[] = { "net.", NULL };

static const lt_optim_group clipping[] = {
    { .name = "a", .prefix = in_a, .kind = LT_SGD, .momentum = 0.9, .schedule = { .lr = 0.05 }, .clip_norm = 0.5 },
    { .name = "b", .prefix = in_net, .kind = LT_SGD, .schedule = { .lr = 0.1 }, .clip_norm = 0.5 },
    { .name = "points", .kind = LT_ADAM, .eps = 1e-15, .schedule = { .lr = 0.02 } },
};

/* One norm over the two networks, or a norm for each; never of the points. */
START_TEST(clipped_together_or_alone)
{
    lt_optim_group group[WEIGHTS];
    lt_optim *o;

    add_weights(names, -1);
    memcpy(group, clipping, sizeof(group));
    group[0].clip_alone = group[1].clip_alone = _i;
    o = lt_optim_new_groups(set, group, WEIGHTS, NULL);
    for (int step = 1; step <= STEPS; step++)
        take_step(o, step, UINT64_MAX, 0);
    check_weights(_i ? want_alone : want_joint, 5e-7);
    lt_optim_free(o);
}
END_TEST

START_TEST(a_phase_has_some_groups)
{
    lt_optim_group group[WEIGHTS];
    lt_optim *o;

    add_weights(names, -1);
    for (int k = 0; k < WEIGHTS; k++) {
        group[k] = clipping[k];
        group[k].kind = LT_ADAM;
        group[k].eps = 0;
        group[k].clip_norm = 0;
        group[k].schedule.lr = 0.05;
    }
    o = lt_optim_new_groups(set, group, WEIGHTS, &(lt_optim_average){ .decay = 0.5 });
    for (int step = 1; step <= STEPS; step++) {
        const uint64_t groups = 1u | (step > 3) << 1 | (step % 2 == 1) << 2;
        lt_real still[N];

        memcpy(still, lt_optim_state_at(o, 5).data, sizeof(still));     /* optim.ema.net.b.weight */
        w[1]->grad[0] = NAN;                            /* nobody looks at it */
        set_gradients(step);
        if (step <= 3)
            w[1]->grad[0] = NAN;
        ck_assert(isfinite(lt_optim_groups_norm(o, groups)));
        lt_optim_step_groups(o, &(lt_optim_now){ .groups = groups });
        if (step <= 3)
            ck_assert_mem_eq(still, lt_optim_state_at(o, 5).data, sizeof(still));
    }
    check_weights(want_phases, 5e-7);
    ck_assert_int_eq(lt_optim_steps(o), STEPS);
    lt_optim_free(o);
}
END_TEST

static const char *const of_yolo[] = { "conv.bias", "conv.weight", "bn.weight" };
static const char *const biases[] = { "bias", NULL };

#define YOLO_SGD .kind = LT_SGD, .nesterov = true, .momentum = 0.937, .warmup_momentum = 0.8
#define YOLO_LR .kind = LT_LINEAR_LR, .lr = 0.05, .min_lr = 0.0005
#define IN_EPOCHS .epochs = 3, .every = 1, .warmup = 1.5
#define IN_STEPS .epochs = 12, .every = 4, .warmup = 6

/* Four steps an epoch, of which the first six warm up: momentum from 0.8, biases from a high rate, others from none */
START_TEST(the_recipe_of_yolo)
{
    static const lt_optim_group group[] = {
        { .name = "biases", .suffix = biases, YOLO_SGD, .schedule = { YOLO_LR, IN_EPOCHS, .warmup_lr = 0.1 } },
        { .name = "weights", YOLO_SGD, .schedule = { YOLO_LR, IN_EPOCHS }, .weight_decay = 0.1, .decay_rank = 2 },
    };
    lt_optim *o;

    add_weights(of_yolo, 1);
    o = lt_optim_new_groups(set, group, 2, &(lt_optim_average){ .decay = 0.9, .tau = 5 });
    for (int step = 1; step <= 12; step++)
        take_step(o, step, UINT64_MAX, (step - 1) / 4.0);
    check_weights(want_yolo, 1e-6);
    lt_optim_swap_ema(o);
    check_weights(want_yolo_average, 1e-6);
    lt_optim_swap_ema(o);
    check_weights(want_yolo, 1e-6);
    lt_optim_free(o);
}
END_TEST

/* Times in steps are the same schedule on another clock; a list of names spares the norm's weight as its rank did. */
START_TEST(the_same_recipe_told_otherwise)
{
    static const char *const spared[] = { "bn.weight", NULL };
    static const lt_optim_group group[] = {
        { .name = "biases", .suffix = biases, YOLO_SGD, .schedule = { YOLO_LR, IN_EPOCHS, .warmup_lr = 0.1 } },
        { .name = "weights", YOLO_SGD, .weight_decay = 0.1, .no_decay = spared, .by_step = true,
          .schedule = { YOLO_LR, IN_STEPS } },
    };
    lt_optim *o;

    add_weights(of_yolo, -1);
    o = lt_optim_new_groups(set, group, 2, NULL);
    for (int step = 1; step <= 12; step++)
        take_step(o, step, UINT64_MAX, (step - 1) / 4.0);
    check_weights(want_yolo, 1e-6);
    lt_optim_free(o);
}
END_TEST

/* One group that has everything takes the steps that lt_optim_new takes, to the bit. */
START_TEST(one_group_is_the_one_recipe)
{
    static const lt_optim_kind kinds[] = { LT_SGD, LT_ADAM, LT_ADAMW };
    const lt_optim_group group = {
        .name = "all", .kind = kinds[_i], .momentum = 0.9, .nesterov = true, .weight_decay = 0.1, .clip_norm = 0.5,
        .schedule = { .lr = 0.05 },
    };
    const lt_optim_opts opts = {
        .kind = kinds[_i], .momentum = 0.9, .nesterov = true, .weight_decay = 0.1, .clip_norm = 0.5, .ema_decay = 0.7,
    };
    lt_real got[2][WEIGHTS][N], average[2][WEIGHTS][N];

    for (int run = 0; run < 2; run++) {
        lt_optim *o;

        stop();
        start();
        add_weights(names, -1);
        o = run ? lt_optim_new_groups(set, &group, 1, &(lt_optim_average){ .decay = 0.7 }) : lt_optim_new(set, &opts);
        for (int step = 1; step <= STEPS; step++) {
            set_gradients(step);
            if (run) {
                lt_optim_groups_norm(o, 1);
                lt_optim_step_groups(o, &(lt_optim_now){ .groups = 1 });
            } else {
                lt_optim_step(o, 0.05, lt_optim_grad_norm(o));
            }
        }
        for (int k = 0; k < WEIGHTS; k++)
            memcpy(got[run][k], w[k]->data, sizeof(got[run][k]));
        lt_optim_swap_ema(o);
        for (int k = 0; k < WEIGHTS; k++)
            memcpy(average[run][k], w[k]->data, sizeof(average[run][k]));
        lt_optim_free(o);
    }
    ck_assert_mem_eq(got[0], got[1], sizeof(got[0]));
    ck_assert_mem_eq(average[0], average[1], sizeof(average[0]));
}
END_TEST

START_TEST(another_recipe_from_here_on)
{
    lt_optim_group slow = clipping[0];
    lt_optim *o;
    lt_real was;

    add_weights(names, -1);
    o = lt_optim_new_groups(set, clipping, WEIGHTS, NULL);
    take_step(o, 1, UINT64_MAX, 0);
    slow.kind = LT_ADAM;                                /* of no account */
    slow.momentum = slow.clip_norm = 0;
    slow.schedule.lr = 0.5;
    slow.weight_decay = 2;
    slow.decay_rank = 2;
    lt_optim_set_group(o, 0, &slow);
    was = w[0]->data[1];
    set_gradients(2);
    w[0]->grad[1] = 1;
    lt_optim_groups_norm(o, UINT64_MAX);
    lt_optim_step_groups(o, &(lt_optim_now){ .groups = 1 });
    ck_assert_double_eq_tol(w[0]->data[1], was - 0.5, 1e-6);
    lt_optim_free(o);
}
END_TEST

/* ---- schedules ---------------------------------------------------------------------------------------- */

START_TEST(schedules)
{
    static const double at[] = { 0, 1, 7500, 15000, 29999, 30000, 99999 };
    const lt_schedule places = {
        .kind = LT_LOG_LINEAR_LR, .lr = 1.6e-4 * 1.0395, .min_lr = 1.6e-6 * 1.0395, .epochs = 30000,
    };
    lt_schedule line = { .kind = LT_LINEAR_LR, .lr = 0.01, .min_lr = 0.0001, .epochs = 10 };

    for (size_t i = 0; i < LT_COUNT(at); i++)
        ck_assert_double_eq_tol(lt_schedule_lr(&places, at[i]), want_log_linear[i], 1e-15);
    for (size_t i = 0; i < LT_COUNT(want_linear); i++)
        ck_assert_double_eq_tol(lt_schedule_lr(&line, (double)i), want_linear[i], 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&line, 2.5), (want_linear[2] + want_linear[3]) / 2, 1e-15);
    line.every = 1;
    ck_assert_double_eq_tol(lt_schedule_lr(&line, 2.99), want_linear[2], 1e-15);
    line.warmup = 4;
    line.warmup_lr = 0.1;
    ck_assert_double_eq_tol(lt_schedule_lr(&line, 0), 0.1, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&line, 1.5), 0.1 + (want_linear[1] - 0.1) * 1.5 / 4, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&line, 4), want_linear[4], 1e-15);
}
END_TEST

/* ---- averages of running statistics ------------------------------------------------------------------- */

START_TEST(statistics_are_averaged_on_demand)
{
    const lt_batch_norm_layer bn = lt_batch_norm_layer_new(set, "bn", 1);
    const lt_optim_group all = { .name = "all", .kind = LT_SGD };
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 2, (int64_t[]){ 4, 1 });
    lt_plan *p = lt_compile(g, &(lt_compile_opts){
        .loss = lt_sum(lt_batch_norm_layer_forward(&bn, x)), .train = true, .replace_grads = true });
    lt_optim *o = lt_optim_new_groups(set, &all, 1, &(lt_optim_average){ .decay = 0.9, .tau = 2, .statistics = _i });
    double average = 0, now = 0;
    int listed = 0;

    for (int step = 1; step <= 3; step++) {
        const double keep = 0.9 * (1 - exp(-step / 2.0));

        for (int i = 0; i < 4; i++)
            ((lt_real *)lt_plan_data(p, x))[i] = (lt_real)(step * step + i);
        check_ok(lt_run(p));
        lt_optim_groups_norm(o, 1);
        lt_optim_step_groups(o, &(lt_optim_now){ .groups = 1 });
        now += 0.1 * (step * step + 1.5 - now);
        average = keep * average + (1 - keep) * now;
    }
    for (int i = 0; i < lt_optim_state_count(o); i++)
        listed += strcmp(lt_optim_state_at(o, i).name, "optim.ema.bn.running_mean") == 0;
    ck_assert_int_eq(listed, _i);
    ck_assert_double_eq_tol(bn.running_mean->data[0], now, 1e-6);
    lt_optim_swap_ema(o);
    ck_assert_double_eq_tol(bn.running_mean->data[0], _i ? average : now, 1e-6);
    lt_optim_swap_ema(o);
    ck_assert_double_eq_tol(bn.running_mean->data[0], now, 1e-6);
    lt_optim_free(o);
    lt_plan_free(p);
    lt_graph_free(g);
}
END_TEST

/* ---- what cannot be; state ---------------------------------------------------------------------------- */

START_TEST(what_makes_no_groups)
{
    static const lt_optim_group nameless = { .kind = LT_SGD }, twins[] = { { .name = "x" }, { .name = "x" } };
    const lt_optim_group *many = clipping;

    add_weights(names, -1);
    ck_assert(!lt_optim_new_groups(set, clipping, 2, NULL));
    ck_assert_str_eq(lt_last_error(), "parameter \"points.place\" is in no group of the optimiser; name it in one, or "
                     "freeze it");
    ck_assert(!lt_optim_new_groups(set, &nameless, 1, NULL));
    ck_assert_str_eq(lt_last_error(), "group 0 of an optimiser has no name");
    ck_assert(!lt_optim_new_groups(set, twins, 2, NULL));
    ck_assert_str_eq(lt_last_error(), "two groups of an optimiser are \"x\"");
    ck_assert(!lt_optim_new_groups(set, many, 65, NULL));
    ck_assert_str_eq(lt_last_error(), "an optimiser of 65 groups, want 1 to 64");
    w[2]->frozen = true;
    lt_optim_free(lt_optim_new_groups(set, clipping, 2, NULL));
}
END_TEST

static void check_states(const lt_optim *o, const char *const *name, int n)
{
    ck_assert_int_eq(lt_optim_state_count(o), n);
    for (int i = 0; i < n; i++)
        ck_assert_str_eq(lt_optim_state_at(o, i).name, name[i]);
}

/* Whichever group has taken how many steps, saved state goes on with the same bits. */
START_TEST(state_resumes)
{
    static const char *const listed[] = {
        "optim.m.net.a.weight", "optim.ema.net.a.weight", "optim.m.net.b.weight", "optim.ema.net.b.weight",
        "optim.m.points.place", "optim.v.points.place", "optim.ema.points.place", "optim.steps.a", "optim.steps.b",
        "optim.steps.points",
    };
    enum { STATES = LT_COUNT(listed) };
    const lt_optim_average average = { .decay = 0.9, .tau = 5 };
    lt_real saved[STATES][N], weights[WEIGHTS][N], at_end[WEIGHTS][N];
    lt_optim *o, *again;

    add_weights(names, -1);
    o = lt_optim_new_groups(set, clipping, WEIGHTS, &average);
    check_states(o, listed, STATES);
    for (int step = 1; step <= 2 * STEPS; step++) {
        take_step(o, step, step % 3 ? 7 : 3, 0);
        for (int i = 0; step == STEPS && i < STATES; i++) {
            const lt_optim_state s = lt_optim_state_at(o, i);

            memcpy(saved[i], s.data, (size_t)lt_shape_numel(&s.shape) * sizeof(lt_real));
        }
        for (int k = 0; k < WEIGHTS; k++)
            memcpy(step == STEPS ? weights[k] : at_end[k], w[k]->data, sizeof(at_end[k]));
    }
    for (int k = 0; k < WEIGHTS; k++)
        memcpy(w[k]->data, weights[k], sizeof(weights[k]));
    again = lt_optim_new_groups(set, clipping, WEIGHTS, &average);
    for (int i = 0; i < STATES; i++) {
        const lt_optim_state s = lt_optim_state_at(again, i);

        memcpy(s.data, saved[i], (size_t)lt_shape_numel(&s.shape) * sizeof(lt_real));
    }
    lt_optim_set_steps(again, STEPS);
    ck_assert_double_eq(lt_optim_state_at(again, STATES - 1).data[0], 4);
    for (int step = STEPS + 1; step <= 2 * STEPS; step++)
        take_step(again, step, step % 3 ? 7 : 3, 0);
    for (int k = 0; k < WEIGHTS; k++)
        ck_assert_mem_eq(w[k]->data, at_end[k], sizeof(at_end[k]));
    for (int i = 0; i < STATES; i++) {
        const lt_optim_state a = lt_optim_state_at(o, i), b = lt_optim_state_at(again, i);

        ck_assert_mem_eq(a.data, b.data, (size_t)lt_shape_numel(&a.shape) * sizeof(lt_real));
    }
    lt_optim_free(o);
    lt_optim_free(again);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_loop_test(tc, clipped_together_or_alone, 0, 2);
    tcase_add_test(tc, a_phase_has_some_groups);
    tcase_add_test(tc, the_recipe_of_yolo);
    tcase_add_test(tc, the_same_recipe_told_otherwise);
    tcase_add_loop_test(tc, one_group_is_the_one_recipe, 0, 3);
    tcase_add_test(tc, another_recipe_from_here_on);
    tcase_add_test(tc, schedules);
    tcase_add_loop_test(tc, statistics_are_averaged_on_demand, 0, 2);
    tcase_add_test(tc, what_makes_no_groups);
    tcase_add_test(tc, state_resumes);
}

int main(void)
{
    return run_suite("groups", add_tests);
}
