/* SPDX-License-Identifier: Apache-2.0 */
/* What one op does of another's work: fewer steps, and the numbers of a plan where nothing fuses. */
#include "tests/graph/graphs.h"

#include "libtensor/graph/int8.h"

#include <math.h>

typedef struct { lt_plan *fused, *plain; } both;

/* For training if there is a loss */
static both compile_both(lt_tensor *loss)
{
    const lt_compile_opts fused = { .train = loss != NULL, .loss = loss };
    lt_compile_opts plain = fused;
    both p;

    plain.no_fusion = true;
    p = (both){ lt_compile(g, &fused), lt_compile(g, &plain) };
    ck_assert(p.fused && p.plain);
    return p;
}

static void run_both(const both *p, const lt_tensor *x)
{
    fill(p->fused, x, 1);
    fill(p->plain, x, 1);
    lt_run(p->fused);
    lt_run(p->plain);
}

static void expect_near(const both *p, const lt_tensor *y)
{
    for (int64_t i = 0; i < lt_numel(y); i++)
        ck_assert_double_eq_tol(at(p->fused, y, i), at(p->plain, y, i), 2e-6);
}

static void free_both(both *p)
{
    lt_plan_free(p->fused);
    lt_plan_free(p->plain);
}

/* conv, batch norm, residual, relu: one step of inference, and the numbers of the four. */
START_TEST(tails_fuse)
{
    const lt_conv_layer conv = lt_conv_layer_new(set, "c", 3, 3, 3, true, &(lt_conv_opts){ .pad = 1 });
    const lt_batch_norm_layer bn = lt_batch_norm_layer_new(set, "bn", 3);
    lt_tensor *x = input("x", LT_SHAPE(2, 3, 6, 7)), *y;
    both p;

    lt_init_default(set, 3);
    lt_init_uniform(bn.running_mean, 4, 1);
    lt_init_constant(bn.running_var, 0.3);
    y = lt_batch_norm_layer_forward(&bn, lt_conv_layer_forward(&conv, x));
    y = lt_output(lt_leaky_relu(lt_add(y, x), 0.1), "y");
    p = compile_both(NULL);
    ck_assert_int_eq(lt_plan_steps(p.fused), 1);
    ck_assert_int_eq(steps_of(p.fused, "conv2d", "forward"), 1);
    ck_assert_int_eq(lt_plan_steps(p.plain), 4);
    run_both(&p, x);
    expect_near(&p, y);
    free_both(&p);
}
END_TEST

static lt_tensor *leaky(lt_tensor *x) { return lt_leaky_relu(x, 0.1); }

/* An activation is done by what is before it, a convolution or a product. */
START_TEST(activations_fuse)
{
    static lt_tensor *(*const act[])(lt_tensor *x) = { (lt_relu), leaky, (lt_silu), (lt_elu), (lt_gelu), (lt_sigmoid),
                                                        (lt_tanh), (lt_quick_gelu) };
    const lt_conv_layer conv = lt_conv_layer_new(set, "conv", 5, 19, 3, true, &(lt_conv_opts){ .pad = 1 });
    const lt_linear_layer fc = lt_linear_layer_new(set, "fc", 7, 19, true);
    lt_tensor *x = input("x", LT_SHAPE(2, 5, 9, 7)), *y, *z;
    both p;

    lt_init_default(set, 3);
    y = lt_output(act[_i](lt_conv_layer_forward(&conv, x)), "y");
    z = lt_output(act[_i](lt_linear_layer_forward(&fc, x)), "z");
    p = compile_both(NULL);
    ck_assert_int_eq(lt_plan_steps(p.fused), 2);
    ck_assert_int_eq(lt_plan_steps(p.plain), 4);
    run_both(&p, x);
    expect_near(&p, y);
    expect_near(&p, z);
    free_both(&p);
}
END_TEST

/* Squeeze and excitation: the means come with the maps, the gates go into the next layer's reading. */
START_TEST(means_and_gates_fuse)
{
    const lt_conv_layer wide = lt_conv_layer_new(set, "wide", 6, 6, 3, true, &(lt_conv_opts){ .pad = 1, .groups = 6 });
    const lt_conv_layer next = lt_conv_layer_new(set, "next", 6, 20, 1, true, NULL);
    const lt_linear_layer fc = lt_linear_layer_new(set, "fc", 6, 6, true);
    lt_tensor *x = input("x", LT_SHAPE(2, 6, 9, 7)), *y, *gate;
    both p;

    lt_init_default(set, 3);
    y = lt_silu(lt_conv_layer_forward(&wide, x));
    gate = lt_sigmoid(lt_linear_layer_forward(&fc, lt_global_avg_pool(y)));
    y = lt_mul(y, lt_reshape(gate, LT_SHAPE(2, 6, 1, 1)));
    y = lt_output(lt_conv_layer_forward(&next, y), "y");
    p = compile_both(NULL);
    ck_assert_int_eq(lt_plan_steps(p.fused), 3);
    ck_assert_int_eq(lt_plan_steps(p.plain), 7);
    run_both(&p, x);
    expect_near(&p, y);
    free_both(&p);
}
END_TEST

/* A gated map that is looked at elsewhere, and a mean that no convolution makes, keep their steps. */
START_TEST(means_and_gates_stay_where_they_are_wanted)
{
    const lt_conv_layer next = lt_conv_layer_new(set, "next", 6, 5, 1, true, NULL);
    lt_tensor *x = input("x", LT_SHAPE(2, 6, 4, 4)), *gate = input("gate", LT_SHAPE(2, 6, 1, 1));
    lt_tensor *gated = lt_output(lt_mul(x, gate), "gated"), *y = lt_conv_layer_forward(&next, gated);
    lt_plan *p;

    lt_output(lt_global_avg_pool(y), "mean");
    p = lt_compile(g, NULL);
    ck_assert_int_eq(lt_plan_steps(p), 3);
    lt_plan_free(p);
}
END_TEST

/* In training too batch norm does what follows: fewer steps, and the same bits everywhere. */
START_TEST(batch_norms_fuse_in_training)
{
    const lt_batch_norm_layer bn1 = lt_batch_norm_layer_new(set, "bn1", 3);
    const lt_batch_norm_layer bn2 = lt_batch_norm_layer_new(set, "bn2", 3);
    const lt_batch_norm_layer bn3 = lt_batch_norm_layer_new(set, "bn3", 3);
    lt_tensor *x = lt_want_grad(input("x", LT_SHAPE(4, 3, 50, 31))), *y, *loss;
    both p;

    lt_init_default(set, 3);
    y = lt_relu(lt_batch_norm_layer_forward(&bn1, x));
    y = lt_leaky_relu(lt_add(lt_batch_norm_layer_forward(&bn2, lt_tanh(y)), x), 0.1);
    y = lt_silu(lt_batch_norm_layer_forward(&bn3, y));
    loss = lt_sum(lt_mul(y, lt_tanh(y)));
    p = compile_both(loss);
    ck_assert_int_eq(steps_of(p.fused, "leaky_relu", "forward") + steps_of(p.fused, "add", "backward"), 0);
    ck_assert_int_eq(steps_of(p.fused, "silu", "forward") + steps_of(p.fused, "silu", "backward"), 0);
    ck_assert_int_eq(steps_of(p.plain, "silu", "forward") + steps_of(p.plain, "silu", "backward"), 2);
    ck_assert_int_eq(steps_of(p.plain, "leaky_relu", "forward") + steps_of(p.plain, "add", "backward"), 3);
    run_both(&p, x);
    ck_assert(at(p.fused, loss, 0) == at(p.plain, loss, 0));
    for (int64_t i = 0; i < lt_numel(x); i++)
        ck_assert(lt_plan_grad(p.fused, x)[i] == lt_plan_grad(p.plain, x)[i]);
    free_both(&p);
}
END_TEST

typedef struct { const char *act; int k, stride; bool shared, frozen; } normed_case;

static const normed_case normed_cases[] = {
    { "silu", 3, 1, false, false }, { "silu", 5, 2, true, false }, { "relu", 3, 2, false, false },
    { "none", 5, 1, true, false }, { "silu", 3, 1, false, true },
};

static lt_tensor *activate(lt_tensor *x, const char *act)
{
    return strcmp(act, "silu") == 0 ? lt_silu(x) : strcmp(act, "relu") == 0 ? lt_leaky_relu(x, 0.1) : x;
}

/* A depthwise convolution makes the normalised map it reads itself: the same loss, and gradients but for the order of
 * some sums. Not behind a batch norm whose weights are frozen, which measures no batch. */
START_TEST(batch_norms_before_depthwise_fuse_in_training)
{
    enum { C = 3, MOST = 30000 };
    static lt_real grads[2][MOST];
    const normed_case *t = &normed_cases[_i];
    const lt_batch_norm_layer bn = lt_batch_norm_layer_new(set, "bn", C);
    const lt_conv_layer conv = lt_conv_layer_new(set, "conv", C, C, t->k, false,
                                                 &(lt_conv_opts){ .stride = t->stride, .pad = t->k / 2, .groups = C });
    lt_tensor *x = lt_want_grad(input("x", LT_SHAPE(3, C, 47, 50))), *z = lt_tanh(x), *y, *loss;
    both p;
    int64_t n;

    lt_init_default(set, 3);
    lt_init_uniform(bn.weight, 5, 1);
    bn.weight->frozen = bn.bias->frozen = t->frozen;
    y = lt_conv_layer_forward(&conv, activate(lt_batch_norm_layer_forward(&bn, z), t->act));
    loss = lt_sum(lt_mul(y, lt_tanh(y)));
    if (t->shared)
        loss = lt_add(loss, lt_sum(lt_mul(z, z)));
    p = compile_both(loss);
    ck_assert_int_eq(steps_of(p.fused, "norm_depthwise", "backward"), !t->frozen);
    ck_assert_int_eq(steps_of(p.fused, "batch_norm", "forward"), t->frozen);
    ck_assert_int_eq(steps_of(p.plain, "conv2d", "backward"), 1);
    fill(p.fused, x, 1);
    fill(p.plain, x, 1);
    n = run_for_gradients(p.fused, x, grads[0]);
    ck_assert_int_le(n, MOST - 1000);
    ck_assert_int_eq(run_for_gradients(p.plain, x, grads[1]), n);
    ck_assert(at(p.fused, loss, 0) == at(p.plain, loss, 0));
    for (int64_t i = 0; i < n; i++)
        ck_assert_double_eq_tol(grads[0][i], grads[1][i], 2e-5 * (1 + fabs((double)grads[1][i])));
    free_both(&p);
}
END_TEST

static int linear_steps(const lt_compile_opts *opts)
{
    lt_plan *p = lt_compile(g, opts);
    const int n = steps_of(p, "linear", "forward");

    lt_plan_free(p);
    return n;
}

/* Two products after each other with many rows: one step, and the same bits; the larger ones are made on tiles, where
 * there are any. */
START_TEST(products_fuse_in_pairs)
{
    const int64_t outer = _i ? 64 : 7, hidden = _i ? 96 : 30;
    const lt_linear_layer fc1 = lt_linear_layer_new(set, "fc1", outer, hidden, true);
    const lt_linear_layer fc2 = lt_linear_layer_new(set, "fc2", hidden, outer, false);
    lt_tensor *x = input("x", LT_SHAPE(3, 90, outer)), *y;
    both p;

    lt_init_default(set, 3);
    y = lt_linear_layer_forward(&fc2, lt_gelu(lt_linear_layer_forward(&fc1, x)));
    y = lt_output(lt_add(y, x), "y");
    p = compile_both(NULL);
    ck_assert_int_eq(lt_plan_steps(p.fused), 1);
    ck_assert_int_eq(lt_plan_macs(p.fused), lt_plan_macs(p.plain));
    run_both(&p, x);
    for (int64_t i = 0; i < lt_numel(y); i++)
        ck_assert(at(p.fused, y, i) == at(p.plain, y, i));
    free_both(&p);
}
END_TEST

/* With few rows the threads share the weights, and integers are read from what lies between. */
START_TEST(products_stay_apart_where_they_must)
{
    const lt_linear_layer fc1 = lt_linear_layer_new(set, "fc1", 7, 30, true);
    const lt_linear_layer fc2 = lt_linear_layer_new(set, "fc2", 30, 7, true);
    const lt_int8_table nothing = { 0 };

    lt_init_default(set, 3);
    lt_output(lt_linear_layer_forward(&fc2, lt_linear_layer_forward(&fc1, input("x", LT_SHAPE(300, 7)))), "y");
    ck_assert_int_eq(linear_steps(NULL), 1);
    ck_assert_int_eq(linear_steps(&(lt_compile_opts){ .int8 = &nothing }), 2);
    lt_output(lt_linear_layer_forward(&fc2, lt_linear_layer_forward(&fc1, input("few", LT_SHAPE(9, 7)))), "z");
    ck_assert_int_eq(linear_steps(NULL), 3);
}
END_TEST

/* A product that someone else reads, or that is an output, keeps its own step. */
START_TEST(what_is_read_twice_does_not_fuse)
{
    const lt_linear_layer fc = lt_linear_layer_new(set, "fc", 3, 3, true);
    lt_tensor *x = input("x", LT_SHAPE(2, 3)), *h = lt_linear_layer_forward(&fc, x);
    lt_plan *p;

    lt_output(lt_add(lt_gelu(h), lt_sigmoid(h)), "y");
    p = lt_compile(g, NULL);
    ck_assert_int_eq(lt_plan_steps(p), 4);
    lt_plan_free(p);
}
END_TEST

/* In training dropout does the relu before it: no steps for that, and the same numbers. */
START_TEST(dropout_takes_a_relu_over)
{
    static const double slopes[] = { 0, 0.1 };
    lt_tensor *x = lt_want_grad(input("x", LT_SHAPE(5, 1001)));
    lt_tensor *y = lt_output(lt_dropout(lt_leaky_relu(lt_tanh(x), slopes[_i]), 0.25), "y");
    lt_tensor *loss = lt_sum(lt_mul(y, y));
    both p = compile_both(loss);

    ck_assert_int_eq(steps_of(p.fused, "leaky_relu", "forward") + steps_of(p.fused, "leaky_relu", "backward"), 0);
    ck_assert_int_eq(steps_of(p.plain, "leaky_relu", "forward") + steps_of(p.plain, "leaky_relu", "backward"), 2);
    run_both(&p, x);
    for (int64_t i = 0; i < lt_numel(x); i++) {
        ck_assert_double_eq_tol(at(p.fused, y, i), at(p.plain, y, i), 1e-6);
        ck_assert_double_eq_tol(lt_plan_grad(p.fused, x)[i], lt_plan_grad(p.plain, x)[i], 1e-6);
    }
    free_both(&p);
}
END_TEST

/* ---- what a model has of constants alone ------------------------------------------------------------------ */

/* A constant (16, 32) through two linear layers, and a constant map through a convolution and a batch norm: as learned
 * queries are. */
static lt_tensor *constant_layers(lt_tensor *x)
{
    lt_tensor *q = weight("query", "tokens", LT_SHAPE(256, 32)), *map = weight("query", "map", LT_SHAPE(1, 4, 5, 5));
    const lt_batch_norm_layer norm = lt_batch_norm_layer_new(set, "norm", 4);

    lt_init_uniform(norm.weight, 1, 1);
    lt_init_uniform(norm.running_mean, 2, 1);
    lt_init_constant(norm.running_var, 2);
    q = linear("second", lt_gelu(linear("first", q, 64)), 32);
    map = lt_batch_norm_layer_forward(&norm, conv("conv", map, 4, 3, 1));
    return lt_add(lt_mul(x, lt_sum(q)), lt_mul(x, lt_sum(lt_mul(map, map))));
}

static lt_real run_constants(const lt_compile_opts *opts, bool refresh)
{
    lt_tensor *x, *y;
    lt_plan *p;
    lt_real out;

    stop();
    start();
    x = input("x", LT_SHAPE(3));
    y = lt_output(constant_layers(x), "y");
    p = compile_filled(x, opts);
    if (refresh)
        lt_plan_refresh(p);
    lt_run(p);
    out = at(p, y, 1);
    lt_plan_free(p);
    return out;
}

START_TEST(constant_layers_are_not_fused_wrongly)
{
    const double plain = run_constants(&(lt_compile_opts){ .no_fusion = true }, false);

    ck_assert_double_eq_tol(run_constants(NULL, false), plain, 1e-5 * fabs(plain));
    ck_assert_double_eq_tol(run_constants(NULL, true), plain, 1e-5 * fabs(plain));
}
END_TEST

/* It keeps its softmax for a backward pass that an inference plan has not. */
START_TEST(a_loss_of_constants)
{
    const lt_real target[] = { 1, 0, 0, 1 };
    lt_tensor *x, *y, *w;
    lt_plan *p;

    x = input("x", LT_SHAPE(1));
    w = weight("query", "logits", LT_SHAPE(2, 2));
    y = lt_output(lt_add(x, lt_cross_entropy(w, lt_constant(g, LT_F32, LT_SHAPE(2, 2), target), NULL)), "y");
    p = compile_filled(x, NULL);
    lt_run(p);
    ck_assert_double_gt(at(p, y, 0) - at(p, x, 0), 0.1);
    lt_plan_free(p);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_test(tc, constant_layers_are_not_fused_wrongly);
    tcase_add_test(tc, a_loss_of_constants);
    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_test(tc, tails_fuse);
    tcase_add_loop_test(tc, activations_fuse, 0, 8);
    tcase_add_test(tc, means_and_gates_fuse);
    tcase_add_test(tc, means_and_gates_stay_where_they_are_wanted);
    tcase_add_test(tc, batch_norms_fuse_in_training);
    tcase_add_loop_test(tc, batch_norms_before_depthwise_fuse_in_training, 0,
                        sizeof(normed_cases) / sizeof(normed_cases[0]));
    tcase_add_loop_test(tc, products_fuse_in_pairs, 0, 2);
    tcase_add_test(tc, products_stay_apart_where_they_must);
    tcase_add_test(tc, what_is_read_twice_does_not_fuse);
    tcase_add_loop_test(tc, dropout_takes_a_relu_over, 0, 2);
}

int main(void)
{
    return run_suite("fuse", add_tests);
}
