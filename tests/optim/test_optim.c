/* SPDX-License-Identifier: Apache-2.0 */
/* Optimisers against PyTorch over some steps; clipping, averages, state, schedules, running statistics. */
#include "libtensor/graph/plan.h"
#include "libtensor/nn/init.h"
#include "libtensor/nn/layers.h"
#include "libtensor/optim/optim.h"
#include "tests/optim/optim_vectors.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { N = 5, STEPS = 6 };

static lt_params *set;
static lt_param *w;

static void start(void)
{
    set = lt_params_new();
    w = lt_params_add(set, "fc", "weight", LT_WEIGHT, LT_SHAPE(N));
    lt_param_need_grad(w);
    for (int i = 0; i < N; i++)
        w->data[i] = (lt_real)(i - 2) / 4;
    ck_assert_int_eq(lt_kernels_init(), LT_OK);
}

static void stop(void)
{
    lt_params_free(set);
}

/* The same formula as in scripts/vectors/optim.py. */
static void set_gradient(int step)
{
    for (int i = 0; i < N; i++)
        w->grad[i] = (lt_real)((i + 1) * (w->data[i] - 0.25) + sin((i + 1.0) * step) / 8);
}

static void steps(lt_optim *o, int from, int to)
{
    for (int step = from; step <= to; step++) {
        set_gradient(step);
        lt_optim_step(o, 0.05, lt_optim_grad_norm(o));
    }
}

static const struct {
    lt_optim_opts opts;
    const double *want;
} kinds[] = {
    { { .kind = LT_SGD, .weight_decay = 0.1 }, want_sgd },
    { { .kind = LT_SGD, .momentum = 0.9, .weight_decay = 0.1 }, want_momentum },
    { { .kind = LT_SGD, .momentum = 0.9, .nesterov = true }, want_nesterov },
    { { .kind = LT_ADAM }, want_adam },
    { { .kind = LT_ADAM, .beta1 = 0.8, .beta2 = 0.99, .eps = 1e-6, .weight_decay = 0.1 }, want_adam_l2 },
    { { .kind = LT_ADAMW, .weight_decay = 0.1 }, want_adamw },
    { { .kind = LT_SGD, .clip_norm = 0.5 }, want_clipped },
};

START_TEST(pytorch_agrees)
{
    lt_optim *o = lt_optim_new(set, &kinds[_i].opts);

    steps(o, 1, STEPS);
    ck_assert_int_eq(lt_optim_steps(o), STEPS);
    for (int i = 0; i < N; i++)
        ck_assert_double_eq_tol(w->data[i], kinds[_i].want[i], 5e-7);
    lt_optim_free(o);
}
END_TEST

/* Saved state and weights put into a new optimiser go on with the same bits. */
START_TEST(state_resumes)
{
    const lt_optim_opts opts = { .kind = LT_ADAM, .ema_decay = 0.9 };
    lt_optim *o = lt_optim_new(set, &opts), *again;
    lt_real at_3[N], at_end[N], state[3][N];

    steps(o, 1, 3);
    ck_assert_int_eq(lt_optim_state_count(o), 3);
    ck_assert_str_eq(lt_optim_state_at(o, 0).name, "optim.m.fc.weight");
    ck_assert_str_eq(lt_optim_state_at(o, 2).name, "optim.ema.fc.weight");
    for (int i = 0; i < 3; i++)
        memcpy(state[i], lt_optim_state_at(o, i).data, sizeof(state[i]));
    memcpy(at_3, w->data, sizeof(at_3));
    steps(o, 4, STEPS);
    memcpy(at_end, w->data, sizeof(at_end));
    memcpy(w->data, at_3, sizeof(at_3));
    again = lt_optim_new(set, &opts);
    for (int i = 0; i < 3; i++)
        memcpy(lt_optim_state_at(again, i).data, state[i], sizeof(state[i]));
    lt_optim_set_steps(again, 3);
    steps(again, 4, STEPS);
    ck_assert(memcmp(w->data, at_end, sizeof(at_end)) == 0);
    ck_assert(memcmp(lt_optim_state_at(o, 2).data, lt_optim_state_at(again, 2).data, sizeof(at_end)) == 0);
    lt_optim_free(o);
    lt_optim_free(again);
}
END_TEST

START_TEST(the_average_follows)
{
    lt_optim *o = lt_optim_new(set, &(lt_optim_opts){ .kind = LT_SGD, .ema_decay = 0.25 });
    double average[N];
    lt_real now[N];

    for (int i = 0; i < N; i++)
        average[i] = w->data[i];
    for (int step = 1; step <= STEPS; step++) {
        const double keep = step == 1 ? 1.0 / 10 : step == 2 ? 2.0 / 11 : 0.25;

        steps(o, step, step);
        for (int i = 0; i < N; i++)
            average[i] = keep * average[i] + (1 - keep) * w->data[i];
    }
    memcpy(now, w->data, sizeof(now));
    lt_optim_swap_ema(o);
    for (int i = 0; i < N; i++)
        ck_assert_double_eq_tol(w->data[i], average[i], 1e-6);
    lt_optim_swap_ema(o);
    ck_assert(memcmp(now, w->data, sizeof(now)) == 0);
    lt_optim_free(o);
}
END_TEST

START_TEST(what_has_no_gradient_stays)
{
    lt_param *idle = lt_params_add(set, "", "idle", LT_WEIGHT, LT_SHAPE(1));
    lt_param *frozen = lt_params_add(set, "", "frozen", LT_WEIGHT, LT_SHAPE(1));
    lt_param *later = lt_params_add(set, "", "later", LT_WEIGHT, LT_SHAPE(1));
    lt_optim *o;

    idle->data[0] = frozen->data[0] = later->data[0] = 1;
    lt_param_need_grad(frozen);
    lt_param_need_grad(later);
    frozen->frozen = true;
    o = lt_optim_new(set, &(lt_optim_opts){ .kind = LT_ADAMW, .weight_decay = 0.5 });
    later->frozen = true;
    later->grad[0] = 100;
    steps(o, 1, 2);
    ck_assert(idle->data[0] == 1 && frozen->data[0] == 1 && later->data[0] == 1);
    lt_optim_free(o);
}
END_TEST

/* With a rate of its own a parameter takes the steps of that part of the learning rate. */
START_TEST(rate_of_a_parameter)
{
    static const lt_optim_kind with_rate[] = { LT_SGD, LT_ADAM, LT_ADAMW };
    lt_param *slow = lt_params_add(set, "", "slow", LT_WEIGHT, LT_SHAPE(1));
    lt_optim *o;

    ck_assert_double_eq(slow->rate, 1);
    slow->rate = 0.25;
    lt_param_need_grad(slow);
    w->data[0] = slow->data[0] = 0;
    w->grad[0] = slow->grad[0] = 2;
    o = lt_optim_new(set, &(lt_optim_opts){ .kind = with_rate[_i] });
    lt_optim_step(o, 0.125, 1);
    ck_assert(w->data[0] < 0);
    ck_assert_double_eq_tol(slow->data[0], w->data[0] / 4, 1e-8);
    lt_optim_free(o);
}
END_TEST

START_TEST(the_norm_tells_of_bad_gradients)
{
    lt_optim *o = lt_optim_new(set, &(lt_optim_opts){ .kind = LT_SGD });

    for (int i = 0; i < N; i++)
        w->grad[i] = 2;
    ck_assert_double_eq_tol(lt_optim_grad_norm(o), sqrt(4.0 * N), 1e-12);
    w->grad[3] = NAN;
    ck_assert(!isfinite(lt_optim_grad_norm(o)));
    w->grad[3] = INFINITY;
    ck_assert(!isfinite(lt_optim_grad_norm(o)));
    lt_optim_free(o);
}
END_TEST

START_TEST(schedules)
{
    const lt_schedule step = { .kind = LT_STEP_LR, .lr = 0.4, .gamma = 0.5, .every = 10 };
    const lt_schedule cosine = { .kind = LT_COSINE_LR, .lr = 0.4, .min_lr = 0.1, .epochs = 12, .warmup = 2 };
    const lt_schedule constant = { .kind = LT_CONSTANT_LR, .lr = 0.4, .warmup = 4 };
    const lt_schedule all_warmup = { .kind = LT_COSINE_LR, .lr = 0.4, .min_lr = 0.1, .epochs = 2, .warmup = 2 };

    ck_assert_double_eq_tol(lt_schedule_lr(&step, 9.99), 0.4, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&step, 10), 0.2, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&step, 25), 0.1, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&cosine, 1), 0.2, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&cosine, 2), 0.4, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&cosine, 7), 0.25, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&cosine, 12), 0.1, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&cosine, 40), 0.1, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&all_warmup, 2), 0.1, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&constant, 1), 0.1, 1e-15);
    ck_assert_double_eq_tol(lt_schedule_lr(&constant, 99), 0.4, 1e-15);
}
END_TEST

/* Three batches through a batch norm move its running statistics as PyTorch's are moved. */
START_TEST(running_statistics)
{
    const lt_batch_norm_layer bn = lt_batch_norm_layer_new(set, "bn", 2);
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 2, (int64_t[]){ 4, 2 });
    lt_plan *p = lt_compile(g, &(lt_compile_opts){
        .loss = lt_sum(lt_batch_norm_layer_forward(&bn, x)), .train = true });

    for (int c = 0; c < 2; c++)
        bn.running_var->data[c] = bn.weight->data[c] = 1;
    for (int step = 1; step <= 3; step++) {
        for (int i = 0; i < 8; i++)
            ((lt_real *)lt_plan_data(p, x))[i] = (lt_real)(sin(i * step + 1.0) + i / 4.0);
        lt_run(p);
        lt_statistics_update(set, 1);
    }
    for (int c = 0; c < 2; c++) {
        ck_assert_double_eq_tol(bn.running_mean->data[c], want_statistics[c], 3e-7);
        ck_assert_double_eq_tol(bn.running_var->data[c], want_statistics[2 + c], 3e-7);
    }
    lt_plan_free(p);
    lt_graph_free(g);
}
END_TEST

/* A layer that is used twice collects two batches; a frozen one is left alone. */
START_TEST(statistics_of_a_layer_used_twice)
{
    const lt_batch_norm_layer bn = lt_batch_norm_layer_new(set, "bn", 1);
    const lt_batch_norm_layer still = lt_batch_norm_layer_new(set, "still", 1);
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 2, (int64_t[]){ 4, 1 });
    lt_tensor *twice = lt_batch_norm_layer_forward(&bn, lt_scale(lt_batch_norm_layer_forward(&bn, x), 3));
    lt_plan *p = lt_compile(g, &(lt_compile_opts){
        .loss = lt_sum(lt_batch_norm_layer_forward(&still, twice)), .train = true });

    bn.weight->data[0] = 1;
    still.weight->data[0] = 1;
    still.running_mean->data[0] = 5;
    bn.running_mean->momentum = bn.running_var->momentum = 1;
    for (int i = 0; i < 4; i++)
        ((lt_real *)lt_plan_data(p, x))[i] = (lt_real)(10 + i);
    still.running_mean->frozen = true;
    lt_run(p);
    lt_statistics_update(set, 1);
    ck_assert_double_eq_tol(bn.running_mean->data[0], 11.5 / 2, 1e-5);
    ck_assert_double_eq_tol(bn.running_var->data[0], (5.0 / 3 + 9 * 4.0 / 3) / 2, 1e-3);
    ck_assert(still.running_mean->data[0] == 5);
    lt_plan_free(p);
    lt_graph_free(g);
}
END_TEST

/* A batch of no or one value says nothing of a spread: running statistics stay. */
START_TEST(statistics_of_a_batch_too_small)
{
    const lt_batch_norm_layer bn = lt_batch_norm_layer_new(set, "bn", 1);
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 2, (int64_t[]){ _i, 1 });
    lt_plan *p = lt_compile(g, &(lt_compile_opts){
        .loss = lt_sum(lt_batch_norm_layer_forward(&bn, x)), .train = true });

    bn.running_mean->data[0] = 5;
    bn.running_var->data[0] = 2;
    lt_run(p);
    lt_statistics_update(set, 1);
    ck_assert(bn.running_mean->data[0] == 5 && bn.running_var->data[0] == 2);
    lt_plan_free(p);
    lt_graph_free(g);
}
END_TEST

/* ---- nothing to be forgotten ---------------------------------------------------------------------- */

/* A layer and a batch norm, to train, and an inference plan made before anything is learnt. */
typedef struct {
    lt_batch_norm_layer bn;
    lt_graph *g;
    lt_tensor *x, *y;
    lt_plan *train, *infer;
} learner;

static learner learner_new(bool replace_grads)
{
    const lt_linear_layer layer = lt_linear_layer_new(set, "layer", 3, 2, true);
    learner l = { .bn = lt_batch_norm_layer_new(set, "bn", 2), .g = lt_graph_new() };
    lt_tensor *loss;

    lt_init_default(set, 1);
    l.x = lt_input(l.g, "x", LT_F32, 2, (int64_t[]){ 4, 3 });
    l.y = lt_output(lt_batch_norm_layer_forward(&l.bn, lt_linear_layer_forward(&layer, l.x)), "y");
    loss = lt_mse_loss(l.y, lt_input(l.g, "want", LT_F32, 2, (int64_t[]){ 4, 2 }), NULL);
    l.infer = lt_compile(l.g, NULL);
    l.train = lt_compile(l.g, &(lt_compile_opts){ .loss = loss, .train = true, .replace_grads = replace_grads });
    for (int i = 0; i < 12; i++)
        ((lt_real *)lt_plan_data(l.train, l.x))[i] = ((lt_real *)lt_plan_data(l.infer, l.x))[i] = (lt_real)sin(i);
    return l;
}

static void learner_free(learner *l)
{
    lt_plan_free(l->train);
    lt_plan_free(l->infer);
    lt_graph_free(l->g);
}

/* What the plan made first says, and what one made now says */
static void check_infer(const learner *l)
{
    lt_plan *now = lt_compile(l->g, NULL);

    memcpy(lt_plan_data(now, l->x), lt_plan_data(l->infer, l->x), 12 * sizeof(lt_real));
    lt_run(now);
    lt_run(l->infer);
    ck_assert_mem_eq(lt_plan_data(l->infer, l->y), lt_plan_data(now, l->y), 8 * sizeof(lt_real));
    lt_plan_free(now);
}

START_TEST(an_inference_plan_refreshes_itself)
{
    learner l = learner_new(true);
    lt_optim *o = lt_optim_new(set, &(lt_optim_opts){ .kind = LT_ADAM, .ema_decay = .5 });

    check_infer(&l);
    for (int step = 0; step < 3; step++) {
        lt_run(l.train);
        lt_optim_step(o, .1, lt_optim_grad_norm(o));
        check_infer(&l);
    }
    lt_optim_swap_ema(o);
    check_infer(&l);
    lt_init_constant(l.bn.weight, 3);
    check_infer(&l);
    lt_run(l.train);
    lt_statistics_update(set, 1);
    check_infer(&l);
    l.bn.bias->data[0] = 7;
    lt_params_changed(set);
    check_infer(&l);
    lt_optim_free(o);
    learner_free(&l);
}
END_TEST

/* The step moves the statistics: once, whether lt_statistics_update comes before it, behind it or never. */
START_TEST(a_step_updates_the_statistics)
{
    learner l = learner_new(true);
    lt_optim *o = lt_optim_new(set, &(lt_optim_opts){ .kind = LT_SGD });
    lt_real mean;

    lt_run(l.train);
    mean = (lt_real)(l.bn.running_mean->momentum * l.bn.running_mean->grad[0]);
    ck_assert(mean != 0);
    if (_i == 1)
        lt_statistics_update(set, 1);
    lt_optim_step(o, 0, 1);
    if (_i == 2)
        lt_statistics_update(set, 1);
    lt_optim_step(o, 0, 1);                             /* nothing new was measured */
    ck_assert_double_eq(l.bn.running_mean->data[0], mean);
    lt_optim_free(o);
    learner_free(&l);
}
END_TEST

/* Sums of several runs are the mean of as many batches; forgotten gradients do not count. */
START_TEST(a_step_knows_how_many_batches_were_summed)
{
    learner l = learner_new(false);
    lt_optim *o = lt_optim_new(set, &(lt_optim_opts){ .kind = LT_SGD });
    lt_real once;

    lt_run(l.train);
    lt_params_zero_grad(set);
    lt_run(l.train);
    once = l.bn.running_mean->grad[0];
    lt_run(l.train);
    ck_assert_double_eq(l.bn.running_mean->grad[0], 2 * once);
    lt_optim_step(o, 0, 1);
    ck_assert_double_eq_tol(l.bn.running_mean->data[0], l.bn.running_mean->momentum * once, 1e-9);
    lt_optim_free(o);
    learner_free(&l);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_loop_test(tc, pytorch_agrees, 0, (int)LT_COUNT(kinds));
    tcase_add_test(tc, state_resumes);
    tcase_add_test(tc, statistics_of_a_layer_used_twice);
    tcase_add_test(tc, an_inference_plan_refreshes_itself);
    tcase_add_loop_test(tc, a_step_updates_the_statistics, 0, 3);
    tcase_add_test(tc, a_step_knows_how_many_batches_were_summed);
    tcase_add_loop_test(tc, statistics_of_a_batch_too_small, 0, 2);
    tcase_add_test(tc, the_average_follows);
    tcase_add_test(tc, what_has_no_gradient_stays);
    tcase_add_loop_test(tc, rate_of_a_parameter, 0, 3);
    tcase_add_test(tc, the_norm_tells_of_bad_gradients);
    tcase_add_test(tc, schedules);
    tcase_add_test(tc, running_statistics);
}

int main(void)
{
    return run_suite("optim", add_tests);
}
