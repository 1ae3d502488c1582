/* SPDX-License-Identifier: Apache-2.0 */
/* Muon against singular values by PyTorch's linear algebra; what it leaves to AdamW; its state; threads. */
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/kernels.h"
#include "libtensor/optim/optim.h"
#include "tests/optim/optim_vectors.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { STEPS = 6, MOST = 96 * 128 };

static const lt_optim_opts muon = { .kind = LT_MUON, .momentum = 0.95, .weight_decay = 0.1, .clip_norm = 20 };

static lt_params *set;

static void start(void)
{
    set = lt_params_new();
    check_ok(lt_kernels_init());
}

static void stop(void)
{
    lt_set_threads(0);
    lt_params_free(set);
}

static lt_param *weight(const char *name, lt_shape shape)
{
    lt_param *w = lt_params_add(set, "", name, LT_WEIGHT, shape);

    ck_assert(lt_param_need_grad(w));
    for (int64_t i = 0; i < lt_param_numel(w); i++)
        w->data[i] = (lt_real)i / 8 - 1;
    return w;
}

/* The same formula as in scripts/vectors/optim.py. */
static void step(lt_optim *o, lt_param *w, int t)
{
    for (int64_t i = 0; i < lt_param_numel(w); i++)
        w->grad[i] = (lt_real)((i + 1.0) * (w->data[i] - 0.25) / 8 + sin((i + 1.0) * t));
    lt_optim_step(o, 0.05, lt_optim_grad_norm(o));
}

START_TEST(singular_values_agree)
{
    const double *want = _i ? want_muon_tall : want_muon_wide;
    lt_param *w = weight("matrix", _i ? LT_SHAPE(5, 3) : LT_SHAPE(3, 5));
    lt_optim *o = lt_optim_new(set, &muon);

    for (int t = 1; t <= STEPS; t++)
        step(o, w, t);
    for (int i = 0; i < 15; i++)
        ck_assert_msg(fabs((double)w->data[i] - want[i]) < 2e-6, "[%d] is %.9g, want %.9g", i, (double)w->data[i],
                      want[i]);
    lt_optim_free(o);
}
END_TEST

/* A vector moves as by AdamW, and the averages of both follow. */
START_TEST(what_is_no_matrix)
{
    lt_optim_opts opts = muon;
    lt_real at_end[2][5];

    opts.ema_decay = 0.5;
    for (int k = 0; k < 2; k++) {
        lt_param *w;
        lt_optim *o;

        lt_params_free(set);
        set = lt_params_new();
        w = weight("vector", LT_SHAPE(5));
        opts.kind = k ? LT_ADAMW : LT_MUON;
        o = lt_optim_new(set, &opts);
        for (int t = 1; t <= STEPS; t++)
            step(o, w, t);
        memcpy(at_end[k], w->data, sizeof(at_end[k]));
        lt_optim_free(o);
    }
    ck_assert_mem_eq(at_end[0], at_end[1], sizeof(at_end[0]));
}
END_TEST

START_TEST(state_resumes)
{
    lt_optim_opts opts = muon;
    lt_param *w = weight("matrix", LT_SHAPE(3, 5));
    lt_real saved[2][15], weights[15], at_end[15];
    lt_optim *o, *again;

    opts.ema_decay = 0.9;
    o = lt_optim_new(set, &opts);
    ck_assert_int_eq(lt_optim_state_count(o), 2);
    ck_assert_str_eq(lt_optim_state_at(o, 0).name, "optim.m.matrix");
    ck_assert_str_eq(lt_optim_state_at(o, 1).name, "optim.ema.matrix");
    for (int t = 1; t <= 2 * STEPS; t++) {
        step(o, w, t);
        if (t != STEPS)
            continue;
        memcpy(weights, w->data, sizeof(weights));
        for (int i = 0; i < 2; i++)
            memcpy(saved[i], lt_optim_state_at(o, i).data, sizeof(saved[i]));
    }
    memcpy(at_end, w->data, sizeof(at_end));
    memcpy(w->data, weights, sizeof(weights));
    again = lt_optim_new(set, &opts);
    for (int i = 0; i < 2; i++)
        memcpy(lt_optim_state_at(again, i).data, saved[i], sizeof(saved[i]));
    lt_optim_set_steps(again, STEPS);
    for (int t = STEPS + 1; t <= 2 * STEPS; t++)
        step(again, w, t);
    ck_assert_mem_eq(w->data, at_end, sizeof(at_end));
    ck_assert_mem_eq(lt_optim_state_at(o, 1).data, lt_optim_state_at(again, 1).data, sizeof(at_end));
    lt_optim_free(o);
    lt_optim_free(again);
}
END_TEST

/* Without a gradient a matrix only decays, and one that is frozen later stays. */
START_TEST(nothing_to_follow)
{
    lt_param *w = weight("matrix", LT_SHAPE(3, 5)), *later = weight("later", LT_SHAPE(2, 2));
    lt_optim *o = lt_optim_new(set, &muon);

    memset(w->grad, 0, 15 * sizeof(lt_real));
    later->frozen = true;
    later->grad[0] = 100;
    lt_optim_step(o, 0.05, lt_optim_grad_norm(o));
    for (int i = 0; i < 15; i++)
        ck_assert_double_eq_tol((double)w->data[i], (i / 8.0 - 1) * (1 - 0.05 * 0.1), 1e-6);
    ck_assert(later->data[0] == -1 && later->data[3] == (lt_real)(3 / 8.0 - 1));
    lt_optim_free(o);
}
END_TEST

START_TEST(threads_do_not_matter)
{
    static lt_real first[MOST];

    for (int threads = 1; threads <= 4; threads++) {
        lt_param *w;
        lt_optim *o;

        lt_params_free(set);
        set = lt_params_new();
        lt_set_threads(threads);
        w = weight("matrix", LT_SHAPE(96, 128));
        o = lt_optim_new(set, &muon);
        for (int t = 1; t <= 2; t++)
            step(o, w, t);
        if (threads == 1)
            memcpy(first, w->data, sizeof(first));
        ck_assert_mem_eq(first, w->data, sizeof(first));
        lt_optim_free(o);
    }
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_loop_test(tc, singular_values_agree, 0, 2);
    tcase_add_test(tc, what_is_no_matrix);
    tcase_add_test(tc, state_resumes);
    tcase_add_test(tc, nothing_to_follow);
    tcase_add_test(tc, threads_do_not_matter);
}

int main(void)
{
    return run_suite("muon", add_tests);
}
