/* SPDX-License-Identifier: Apache-2.0 */
/* Inference plans with a table of layers that read 8-bit integers. What the layers compute is held in tests/kernels. */
#include "libtensor/base/parallel.h"
#include "libtensor/graph/int8.h"
#include "libtensor/ops/ops.h"
#include "tests/graph/graphs.h"

#include <math.h>

enum { B = 2, C = 20, H = 13, W = 11, O = 24, FEATURES = 32, OUT = 5 };

static lt_tensor *image, *out;

/* first, a squeeze and excitation whose gates the next layer takes over, a sum, and features. */
static void begin(void)
{
    lt_tensor *a, *gate, *b;

    start();
    image = input("x", LT_SHAPE(B, C, H, W));
    a = lt_relu(conv("first", image, O, 3, 1));
    gate = lt_sigmoid(linear("gate", lt_reshape(lt_global_avg_pool(a), LT_SHAPE(B, O)), O));
    b = conv("gated", lt_mul(a, lt_reshape(gate, LT_SHAPE(B, O, 1, 1))), O, 1, 1);
    b = lt_relu(lt_add(b, a));
    b = lt_relu(linear("features", lt_reshape(lt_global_avg_pool(b), LT_SHAPE(B, O)), FEATURES));
    out = lt_output(linear("head", b, OUT), "y");
}

static const lt_int8_layer layers[] = {
    { "first", { (lt_real)(1.0 / 127), true } }, { "gate", { (lt_real)(1.0 / 255), false } },
    { "gated", { (lt_real)(2.0 / 255), false } }, { "features", { (lt_real)(2.0 / 255), false } },
    { "head", { (lt_real)0.01, false } }, { "nowhere", { (lt_real)0.01, false } },
};
static const lt_int8_table table = { layers, LT_COUNT(layers) };

/* "first gated ", of the steps of a plan that read integers */
static const char *with_integers(const lt_plan *p)
{
    static char list[256];

    *list = '\0';
    for (int i = 0; i < lt_plan_steps(p); i++) {
        const lt_step_info s = lt_plan_step(p, i);

        if (strcmp(s.algorithm, "int8") == 0)
            strcat(strcat(list, s.layer), " ");
    }
    return list;
}

/* All that are named and suit, but the one whose result is looked at. */
START_TEST(layers_of_the_table)
{
    lt_plan *p = compile_filled(image, &(lt_compile_opts){ .int8 = &table });

    ck_assert_str_eq(with_integers(p), "first gate gated features ");
    lt_plan_free(p);
    p = compile_filled(image, NULL);
    ck_assert_str_eq(with_integers(p), "");
    lt_plan_free(p);
}
END_TEST

/* An integer is off by half a step, so a result by less than a hundredth here; and it is not exact. */
START_TEST(near_the_exact_plan)
{
    lt_real exact[B * OUT], rounded[B * OUT];
    double most = 0, off = 0;

    compute(image, out, NULL, exact);
    compute(image, out, &(lt_compile_opts){ .int8 = &table }, rounded);
    for (int i = 0; i < B * OUT; i++) {
        most = fmax(most, fabs((double)exact[i]));
        off = fmax(off, fabs((double)exact[i] - (double)rounded[i]));
    }
    ck_assert_double_gt(most, 0.01);
    ck_assert_double_gt(off, 0);
    ck_assert_double_lt(off, 0.01 * most);
}
END_TEST

START_TEST(same_bits)
{
    lt_real want[B * OUT], got[B * OUT];
    const lt_compile_opts opts = { .int8 = &table }, consuming = { .int8 = &table, .consume_params = true };

    compute(image, out, &opts, want);
    for (int threads = 1; threads <= 4; threads++) {
        lt_set_threads(threads);
        compute(image, out, &opts, got);
        ck_assert(memcmp(got, want, sizeof(want)) == 0);
    }
    compute(image, out, &consuming, got);
    ck_assert(memcmp(got, want, sizeof(want)) == 0);
}
END_TEST

/* New weights are rounded anew. */
START_TEST(refresh)
{
    lt_real before[B * OUT], after[B * OUT];
    lt_plan *p = compile_filled(image, &(lt_compile_opts){ .int8 = &table });

    lt_run(p);
    memcpy(before, lt_plan_data(p, out), sizeof(before));
    lt_params_find(set, "features.weight")->data[0] += 1;
    lt_plan_refresh(p);
    lt_run(p);
    memcpy(after, lt_plan_data(p, out), sizeof(after));
    ck_assert(memcmp(before, after, sizeof(before)) != 0);
    lt_plan_free(p);
    compute(image, out, &(lt_compile_opts){ .int8 = &table }, before);
    ck_assert(memcmp(before, after, sizeof(before)) == 0);
}
END_TEST

typedef struct { char names[256]; int64_t numbers; double most, energy, error; } sight;

static void see(void *ctx, const char *layer, const lt_real *x, int64_t n)
{
    sight *s = ctx;

    strcat(strcat(s->names, layer), " ");
    s->numbers += n;
    for (int64_t i = 0; i < n; i++)
        s->most = fmax(s->most, fabs((double)x[i]));
}

static void see_both(void *ctx, const char *layer, const lt_real *exact, const lt_real *rounded, int64_t n)
{
    sight *s = ctx;

    strcat(strcat(s->names, layer), " ");
    for (int64_t i = 0; i < n; i++) {
        const double error = (double)rounded[i] - (double)exact[i];

        s->energy += (double)exact[i] * (double)exact[i];
        s->error += error * error;
    }
}

/* Before anything is rounded, what could be is shown; then, what that costs each layer by itself. */
START_TEST(observed_and_compared)
{
    sight seen = { .names = "" }, compared = { .names = "" };
    lt_real exact[B * OUT];
    lt_plan *p = compile_filled(image, &(lt_compile_opts){ .no_fusion = true }), *q;

    lt_plan_observe(p, see, &seen);
    ck_assert_str_eq(seen.names, "first gate gated features ");
    ck_assert_int_eq(seen.numbers, B * C * H * W + B * O + B * O * H * W + B * O);
    ck_assert_double_gt(seen.most, 0.9);
    lt_plan_free(p);
    p = compile_filled(image, &(lt_compile_opts){ .int8 = &(lt_int8_table){ 0 } });
    q = compile_filled(image, &(lt_compile_opts){ .int8 = &table });
    lt_plan_compare(p, q, &table, see_both, &compared);
    ck_assert_str_eq(compared.names, "first gate gated features ");
    ck_assert_double_gt(compared.error, 0);
    ck_assert_double_lt(compared.error, 1e-3 * compared.energy);
    memcpy(exact, lt_plan_data(p, out), sizeof(exact));
    lt_run(p);
    ck_assert(memcmp(exact, lt_plan_data(p, out), sizeof(exact)) == 0);
    lt_plan_free(p);
    lt_plan_free(q);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, begin, stop);
    tcase_add_test(t, layers_of_the_table);
    tcase_add_test(t, near_the_exact_plan);
    tcase_add_test(t, same_bits);
    tcase_add_test(t, refresh);
    tcase_add_test(t, observed_and_compared);
}

int main(void)
{
    return run_suite("int8", add_tests);
}
