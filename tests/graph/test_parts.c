/* SPDX-License-Identifier: Apache-2.0 */
/* A batch in parts is the batch in one piece: losses, gradients, statistics, on any number of threads. */
#include "libtensor/base/arena.h"
#include "libtensor/base/parallel.h"
#include "libtensor/graph/plan_internal.h"
#include "tests/graph/graphs.h"

#include <math.h>

enum { BATCH = 6, CHANNELS = 20, SIZE = 21 };

/* Of batch norm what it does alone and for others: without an activation, before silu and a depthwise convolution,
 * with a residual. */
typedef struct {
    lt_conv_layer in, depthwise, out;
    lt_batch_norm_layer norm[4];
    lt_linear_layer fc;
} net;

static net make(void)
{
    const lt_conv_opts same = { .pad = 1 }, each = { .pad = 1, .groups = CHANNELS };
    net m = { .in = lt_conv_layer_new(set, "in", 3, CHANNELS, 3, false, &same) };

    m.depthwise = lt_conv_layer_new(set, "depthwise", CHANNELS, CHANNELS, 3, false, &each);
    m.out = lt_conv_layer_new(set, "out", CHANNELS, CHANNELS, 1, false, NULL);
    for (int i = 0; i < 4; i++)
        m.norm[i] = lt_batch_norm_layer_new(set, lt_name(set, "norm%d", i), CHANNELS);
    m.fc = lt_linear_layer_new(set, "fc", CHANNELS, 4, true);
    for (lt_param *p = lt_params_first(set); p; p = p->next) {
        lt_rng r = lt_rng_make(7, (uint64_t)p->name[0] + (uint64_t)p->name[4]);

        for (int64_t i = 0; p->kind == LT_WEIGHT && i < lt_param_numel(p); i++)
            p->data[i] = (lt_real)lt_rng_range(&r, 0.2, 1.2) * (i % 3 ? 1 : -1);
    }
    return m;
}

/* A graph of n samples, and its plan of so many parts. */
typedef struct {
    lt_graph *g;
    lt_tensor *x, *want, *weight, *loss;
    int n, parts;
    lt_plan *plan;
} subject;

static lt_plan *compile(const subject *s)
{
    return lt_compile(s->g, &(lt_compile_opts){ .train = true, .loss = s->loss, .replace_grads = true,
                                                .parts = s->parts });
}

static subject record(const net *m, int parts)
{
    subject s = { .g = lt_graph_new(), .n = BATCH / parts, .parts = parts };
    const int64_t map[] = { s.n, 3, SIZE, SIZE }, vector[] = { s.n, 4 }, number[] = { s.n };
    lt_tensor *h, *skip;

    s.x = lt_want_grad(lt_input(s.g, "x", LT_F32, 4, map));
    s.want = lt_input(s.g, "want", LT_F32, 2, vector);
    s.weight = lt_input(s.g, "weight", LT_F32, 1, number);
    skip = lt_batch_norm_layer_forward(&m->norm[0], lt_conv_layer_forward(&m->in, s.x));
    h = lt_silu(lt_batch_norm_layer_forward(&m->norm[1], skip));
    h = lt_silu(lt_batch_norm_layer_forward(&m->norm[2], lt_conv_layer_forward(&m->depthwise, h)));
    h = lt_batch_norm_layer_forward(&m->norm[3], lt_conv_layer_forward(&m->out, h));
    h = lt_global_avg_pool(lt_relu(lt_add(h, skip)));
    h = lt_reshape(h, LT_SHAPE(s.n, CHANNELS));
    s.loss = lt_mse_loss(lt_linear_layer_forward(&m->fc, h), s.want, s.weight);
    s.plan = compile(&s);
    return s;
}

static void drop(subject *s)
{
    lt_plan_free(s->plan);
    lt_graph_free(s->g);
}

/* A sample's numbers are the same, however the batch is cut. */
static void fill_part(const subject *s, const lt_tensor *t, int k)
{
    const int64_t size = lt_numel(t) / s->n;
    lt_real *data = lt_plan_data(lt_plan_part(s->plan, k), t);

    for (int i = 0; i < s->n; i++) {
        lt_rng r = lt_rng_make(3, (uint64_t)(100 * t->shape.rank + k * s->n + i));

        for (int64_t j = 0; j < size; j++)
            data[i * size + j] = (lt_real)lt_rng_range(&r, 0.1, 1);
    }
}

/* Fills part k; returns the share of its samples in the batch. */
static double feed(const subject *s, int k)
{
    lt_plan *part = lt_plan_part(s->plan, k);
    lt_real *weight = lt_plan_data(part, s->weight);
    double mine = 0, all = 0;

    fill_part(s, s->x, k);
    fill_part(s, s->want, k);
    for (int i = 0; i < BATCH; i++)
        all += i % 4;
    for (int i = 0; i < s->n; i++)
        mine += weight[i] = (lt_real)((k * s->n + i) % 4);
    lt_plan_set_loss_weight(part, mine / all);
    return mine / all;
}

/* The loss of the batch, and all gradients, the input's first. */
static double run(const subject *s, lt_real *out, int64_t *n)
{
    double loss = 0, share[BATCH];

    for (int k = 0; k < s->parts; k++)
        share[k] = feed(s, k);
    lt_run(s->plan);
    *n = 0;
    for (int k = 0; k < s->parts; k++) {
        const lt_plan *part = lt_plan_part(s->plan, k);
        const size_t numel = (size_t)lt_numel(s->x);

        loss += share[k] * (double)*(lt_real *)lt_plan_data(part, s->loss);
        memcpy(out + *n, lt_plan_grad(part, s->x), numel * sizeof(*out));
        *n += (int64_t)numel;
    }
    for (const lt_param *p = lt_params_first(set); p; p = p->next)
        for (int64_t i = 0; p->grad && i < lt_param_numel(p); i++)
            out[(*n)++] = p->grad[i];
    return loss;
}

enum { MOST = BATCH * 3 * SIZE * SIZE + 8 * CHANNELS * 40 };

START_TEST(parts_are_the_whole)
{
    const net m = make();
    subject whole = record(&m, 1), parts = record(&m, _i);
    static lt_real want[MOST], got[MOST];
    int64_t n, n_got;
    double loss, again, largest = 0;

    ck_assert_msg(whole.plan && parts.plan, "%s", lt_last_error());
    ck_assert_int_eq(steps_of(parts.plan, "norm_depthwise", "forward"), 1);
    loss = run(&whole, want, &n);
    again = run(&parts, got, &n_got);
    ck_assert_double_eq_tol(again, loss, 1e-5 * loss);
    ck_assert_int_eq(n, n_got);
    ck_assert_int_lt(n, MOST);
    for (int64_t i = 0; i < n; i++)
        largest = fmax(largest, fabs((double)want[i]));
    for (int64_t i = 0; i < n; i++)
        ck_assert_double_eq_tol(got[i], want[i], 2e-5 * fabs((double)want[i]) + 2e-7 * largest);
    drop(&whole);
    drop(&parts);
}
END_TEST

/* A slower part reads what a faster one has shared until they meet again; so nothing else may come there before. */
START_TEST(what_is_shared_stays)
{
    const net m = make();
    subject s = record(&m, 2);
    int shares = 0;

    ck_assert_msg(s.plan != NULL, "%s", lt_last_error());
    for (int i = plan_next_share(s.plan, 0); i < s.plan->n_steps; i = plan_next_share(s.plan, i + 1), shares++)
        for (int k = 0; k < LT_MAX_SAVED; k++) {
            const int saved = s.plan->node[s.plan->step[i].node->id].saved[k];

            ck_assert(saved < 0 || s.plan->buffer[saved].last >= plan_next_share(s.plan, i + 1));
        }
    ck_assert_int_eq(shares, 8);
    drop(&s);
}
END_TEST

/* A part a thread, or one after another on all of them */
START_TEST(any_number_of_threads_gives_the_same_bits)
{
    const net m = make();
    subject s = record(&m, 2);
    static lt_real want[MOST], got[MOST];
    int64_t n;

    ck_assert_msg(s.plan != NULL, "%s", lt_last_error());
    for (int threads = 1; threads <= 4; threads++) {
        lt_set_threads(threads);
        run(&s, threads == 1 ? want : got, &n);
        ck_assert(threads == 1 || memcmp(want, got, (size_t)n * sizeof(*got)) == 0);
    }
    drop(&s);
}
END_TEST

/* What an op sums outside of tasks is as small in a part that is a task as in one that is not. */
START_TEST(subnormal_numbers_are_zero_on_any_number_of_threads)
{
    for (int threads = 1; threads <= 4; threads++) {
        lt_tensor *x, *s;
        lt_plan *p;

        lt_set_threads(threads);
        stop();
        start();
        x = input("x", LT_SHAPE(4));
        s = lt_output(lt_sum(lt_add(x, lt_scale(weight("", "w", LT_SHAPE(4)), 0))), "s");
        p = lt_compile(g, &(lt_compile_opts){ .train = true, .replace_grads = true, .parts = 2, .loss = s });
        for (int k = 0; k < 2; k++)
            for (int i = 0; i < 4; i++)
                ((lt_real *)lt_plan_data(lt_plan_part(p, k), x))[i] = (lt_real)(i % 2 ? 1.3e-38 : -1.235e-38);
        lt_run(p);
        ck_assert(*(lt_real *)lt_plan_data(p, s) == 0);
        lt_plan_free(p);
    }
}
END_TEST

START_TEST(a_bad_tensor_of_a_later_part_has_a_name)
{
    const net m = make();
    subject s = record(&m, 3);
    char where[64];

    ck_assert_msg(s.plan != NULL, "%s", lt_last_error());
    for (int k = 0; k < 3; k++)
        feed(&s, k);
    lt_plan_find_nonfinite(s.plan, where, sizeof(where));
    ck_assert_str_eq(where, "");
    *(lt_real *)lt_plan_data(lt_plan_part(s.plan, 2), s.x) = NAN;
    lt_plan_find_nonfinite(s.plan, where, sizeof(where));
    ck_assert_str_eq(where, "conv2d \"in\"");
    drop(&s);
}
END_TEST

START_TEST(parts_draw_numbers_of_their_own)
{
    lt_tensor *x = lt_want_grad(input("x", LT_SHAPE(200))), *y = lt_output(lt_dropout(x, 0.5), "y");
    lt_plan *p = lt_compile(g, &(lt_compile_opts){ .train = true, .loss = lt_sum(y), .replace_grads = true,
                                                   .parts = 2 });
    int differ = 0;

    ck_assert_ptr_nonnull(p);
    for (int k = 0; k < 2; k++)
        fill(lt_plan_part(p, k), x, 1);
    lt_plan_set_step(p, 1, 5);
    lt_run(p);
    for (int i = 0; i < 200; i++)
        differ += at(p, y, i) != at(lt_plan_part(p, 1), y, i);
    ck_assert_int_gt(differ, 50);
    lt_plan_free(p);
}
END_TEST

START_TEST(plans_that_have_no_parts)
{
    lt_tensor *loss = lt_sum(lt_tanh(input("x", LT_SHAPE(2))));

    ck_assert_ptr_null(lt_compile(g, &(lt_compile_opts){ .loss = loss, .parts = 2 }));
    ck_assert_str_eq(lt_last_error(), "a batch in 2 parts, where only a training plan that replaces gradients has "
                     "parts");
    ck_assert_ptr_null(lt_compile(g, &(lt_compile_opts){ .loss = loss, .train = true, .parts = 2 }));
}
END_TEST

START_TEST(every_allocation_may_fail)
{
    const net m = make();
    subject s = record(&m, 2);

    for (int n = 1; n < 1000; n++) {
        lt_plan *p;

        lt_alloc_fail_at(n);
        p = compile(&s);
        lt_alloc_fail_at(0);
        lt_plan_free(p);
        if (p) {
            ck_assert_int_gt(n, 5);
            drop(&s);
            return;
        }
    }
    ck_abort_msg("never succeeds");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_loop_test(tc, parts_are_the_whole, 2, 4);
    tcase_add_test(tc, what_is_shared_stays);
    tcase_add_test(tc, any_number_of_threads_gives_the_same_bits);
    tcase_add_test(tc, subnormal_numbers_are_zero_on_any_number_of_threads);
    tcase_add_test(tc, a_bad_tensor_of_a_later_part_has_a_name);
    tcase_add_test(tc, parts_draw_numbers_of_their_own);
    tcase_add_test(tc, plans_that_have_no_parts);
    tcase_add_test(tc, every_allocation_may_fail);
}

int main(void)
{
    return run_suite("parts", add_tests);
}
