/* SPDX-License-Identifier: Apache-2.0 */
/* Inference plans with a table of layers that read 8-bit integers. What the layers compute is held in tests/kernels. */
#include "libtensor/base/parallel.h"
#include "libtensor/base/rng.h"
#include "libtensor/graph/plan.h"
#include "libtensor/ops/ops.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { B = 2, C = 20, H = 13, W = 11, O = 24, FEATURES = 32, OUT = 5 };

typedef struct {
    lt_params *set;
    lt_graph *g;
    lt_tensor *x, *y;
} network;

static lt_tensor *weight(network *n, const char *layer, const char *name, lt_shape shape)
{
    lt_param *p = lt_params_add(n->set, layer, name, LT_WEIGHT, shape);
    lt_rng r = lt_rng_make(3, (uint64_t)lt_param_numel(p));

    for (int64_t i = 0; i < lt_param_numel(p); i++)
        p->data[i] = (lt_real)lt_rng_range(&r, -0.2, 0.2);
    return lt_use(n->g, p);
}

static lt_tensor *conv(network *n, const char *layer, lt_tensor *x, int64_t outputs, int k)
{
    lt_tensor *w = weight(n, layer, "weight", LT_SHAPE(outputs, lt_dim(x, 1), k, k));

    return lt_conv2d(x, w, weight(n, layer, "bias", LT_SHAPE(outputs)), &(lt_conv_opts){ .pad = k / 2 });
}

static lt_tensor *linear(network *n, const char *layer, lt_tensor *x, int64_t outputs)
{
    lt_tensor *w = weight(n, layer, "weight", LT_SHAPE(outputs, lt_dim(x, -1)));

    return lt_linear(x, w, weight(n, layer, "bias", LT_SHAPE(outputs)));
}

/* first, a squeeze and excitation whose gates the next layer takes over, a sum, and features. */
static void build(network *n)
{
    lt_tensor *a, *gate, *b;

    n->set = lt_params_new();
    n->g = lt_graph_new();
    n->x = lt_input(n->g, "x", LT_F32, 4, (int64_t[]){ B, C, H, W });
    a = lt_relu(conv(n, "first", n->x, O, 3));
    gate = lt_sigmoid(linear(n, "gate", lt_reshape(lt_global_avg_pool(a), LT_SHAPE(B, O)), O));
    b = conv(n, "gated", lt_mul(a, lt_reshape(gate, LT_SHAPE(B, O, 1, 1))), O, 1);
    b = lt_relu(lt_add(b, a));
    b = lt_relu(linear(n, "features", lt_reshape(lt_global_avg_pool(b), LT_SHAPE(B, O)), FEATURES));
    n->y = lt_output(linear(n, "head", b, OUT), "y");
}

static void destroy(network *n)
{
    lt_graph_free(n->g);
    lt_params_free(n->set);
}

static const lt_int8_layer layers[] = {
    { "first", { (lt_real)(1.0 / 127), true } }, { "gate", { (lt_real)(1.0 / 255), false } },
    { "gated", { (lt_real)(2.0 / 255), false } }, { "features", { (lt_real)(2.0 / 255), false } },
    { "head", { (lt_real)0.01, false } }, { "nowhere", { (lt_real)0.01, false } },
};
static const lt_int8_table table = { layers, LT_COUNT(layers) };

static lt_plan *compile(network *n, const lt_compile_opts *opts)
{
    lt_plan *p = lt_compile(n->g, opts);
    lt_rng r = lt_rng_make(5, 0);
    lt_real *x;

    ck_assert_ptr_nonnull(p);
    x = lt_plan_data(p, n->x);
    for (int64_t i = 0; i < lt_numel(n->x); i++)
        x[i] = (lt_real)lt_rng_range(&r, -1, 1);
    return p;
}

static void result(network *n, const lt_compile_opts *opts, lt_real out[B * OUT])
{
    lt_plan *p = compile(n, opts);

    lt_run(p);
    memcpy(out, lt_plan_data(p, n->y), B * OUT * sizeof(*out));
    lt_plan_free(p);
}

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
    network n;
    lt_plan *p;

    build(&n);
    p = compile(&n, &(lt_compile_opts){ .int8 = &table });
    ck_assert_str_eq(with_integers(p), "first gate gated features ");
    lt_plan_free(p);
    p = compile(&n, NULL);
    ck_assert_str_eq(with_integers(p), "");
    lt_plan_free(p);
    destroy(&n);
}
END_TEST

/* An integer is off by half a step, so a result by less than a hundredth here; and it is not exact. */
START_TEST(near_the_exact_plan)
{
    lt_real exact[B * OUT], rounded[B * OUT];
    double most = 0, off = 0;
    network n;

    build(&n);
    result(&n, NULL, exact);
    result(&n, &(lt_compile_opts){ .int8 = &table }, rounded);
    for (int i = 0; i < B * OUT; i++) {
        most = fmax(most, fabs((double)exact[i]));
        off = fmax(off, fabs((double)exact[i] - (double)rounded[i]));
    }
    ck_assert_double_gt(most, 0.01);
    ck_assert_double_gt(off, 0);
    ck_assert_double_lt(off, 0.01 * most);
    destroy(&n);
}
END_TEST

START_TEST(same_bits)
{
    lt_real want[B * OUT], got[B * OUT];
    const lt_compile_opts opts = { .int8 = &table }, consuming = { .int8 = &table, .consume_params = true };
    network n;

    build(&n);
    result(&n, &opts, want);
    for (int threads = 1; threads <= 4; threads++) {
        lt_set_threads(threads);
        result(&n, &opts, got);
        ck_assert(memcmp(got, want, sizeof(want)) == 0);
    }
    result(&n, &consuming, got);
    ck_assert(memcmp(got, want, sizeof(want)) == 0);
    destroy(&n);
}
END_TEST

/* New weights are rounded anew. */
START_TEST(refresh)
{
    lt_real before[B * OUT], after[B * OUT];
    network n;
    lt_plan *p;

    build(&n);
    p = compile(&n, &(lt_compile_opts){ .int8 = &table });
    lt_run(p);
    memcpy(before, lt_plan_data(p, n.y), sizeof(before));
    lt_params_find(n.set, "features.weight")->data[0] += 1;
    lt_plan_refresh(p);
    lt_run(p);
    memcpy(after, lt_plan_data(p, n.y), sizeof(after));
    ck_assert(memcmp(before, after, sizeof(before)) != 0);
    lt_plan_free(p);
    result(&n, &(lt_compile_opts){ .int8 = &table }, before);
    ck_assert(memcmp(before, after, sizeof(before)) == 0);
    destroy(&n);
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
    network n;
    lt_plan *p, *q;

    build(&n);
    p = compile(&n, &(lt_compile_opts){ .no_fusion = true });
    lt_plan_observe(p, see, &seen);
    ck_assert_str_eq(seen.names, "first gate gated features ");
    ck_assert_int_eq(seen.numbers, B * C * H * W + B * O + B * O * H * W + B * O);
    ck_assert_double_gt(seen.most, 0.9);
    lt_plan_free(p);
    p = compile(&n, &(lt_compile_opts){ .int8 = &(lt_int8_table){ 0 } });
    q = compile(&n, &(lt_compile_opts){ .int8 = &table });
    lt_plan_compare(p, q, &table, see_both, &compared);
    ck_assert_str_eq(compared.names, "first gate gated features ");
    ck_assert_double_gt(compared.error, 0);
    ck_assert_double_lt(compared.error, 1e-3 * compared.energy);
    memcpy(exact, lt_plan_data(p, n.y), sizeof(exact));
    lt_run(p);
    ck_assert(memcmp(exact, lt_plan_data(p, n.y), sizeof(exact)) == 0);
    lt_plan_free(p);
    lt_plan_free(q);
    destroy(&n);
}
END_TEST

static void add_tests(TCase *t)
{
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
