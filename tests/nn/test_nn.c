/* SPDX-License-Identifier: Apache-2.0 */
/* Layers: the names and shapes that they register, and what their parameters start from. */
#include "libtensor/graph/plan.h"
#include "libtensor/nn/init.h"
#include "libtensor/nn/layers.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

static lt_params *set;

static void start(void) { set = lt_params_new(); }
static void stop(void) { lt_params_free(set); }

static void expect_param(const char *name, lt_shape want)
{
    const lt_param *p = lt_params_find(set, name);

    ck_assert_msg(p && lt_same_shape(&p->shape, &want), "%s is missing or of another shape", name);
}

START_TEST(layers_register_what_pytorch_calls_them)
{
    lt_conv_layer_new(set, "conv", 6, 8, 3, true, &(lt_conv_opts){ .groups = 2 });
    lt_linear_layer_new(set, "fc", 5, 7, false);
    lt_batch_norm_layer_new(set, "bn", 4);
    lt_layer_norm_layer_new(set, "ln", 9);
    lt_se_layer_new(set, "se", 16, 4);
    lt_attention_layer_new(set, "attn", 12, 3);
    ck_assert_int_eq(lt_params_status(set), LT_OK);
    expect_param("conv.weight", LT_SHAPE(8, 3, 3, 3));
    expect_param("conv.bias", LT_SHAPE(8));
    expect_param("fc.weight", LT_SHAPE(7, 5));
    ck_assert_ptr_null(lt_params_find(set, "fc.bias"));
    expect_param("bn.running_var", LT_SHAPE(4));
    expect_param("ln.weight", LT_SHAPE(9));
    expect_param("se.fc1.weight", LT_SHAPE(4, 16));
    expect_param("se.fc2.weight", LT_SHAPE(16, 4));
    ck_assert_int_eq(lt_params_count(set, LT_STATISTIC, ""), 8);
    ck_assert_int_eq(lt_params_count(set, LT_WEIGHT, "se."), 128);
    expect_param("attn.q.weight", LT_SHAPE(12, 12));
    expect_param("attn.out.bias", LT_SHAPE(12));
    ck_assert_int_eq(lt_params_count(set, LT_WEIGHT, "attn."), 4 * (144 + 12));
}
END_TEST

START_TEST(names_are_taken_once)
{
    lt_param *p;

    lt_linear_layer_new(set, "fc", 5, 7, true);
    p = lt_params_add(set, "fc", "bias", LT_WEIGHT, LT_SHAPE(7));
    ck_assert_int_eq(lt_params_status(set), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "parameter \"fc.bias\" is registered twice");
    ck_assert_ptr_nonnull(p->data);
}
END_TEST

/* Of any length: 20000 characters are a block of their own in the set's arena. */
START_TEST(names_are_never_cut)
{
    char longest[20000 + 1];
    const char *name;

    memset(longest, 'a', sizeof(longest) - 1);
    longest[sizeof(longest) - 1] = '\0';
    name = lt_name(set, "%s.%d", longest, 7);
    ck_assert_int_eq(strlen(name), sizeof(longest) - 1 + 2);
    ck_assert_str_eq(name + sizeof(longest) - 1, ".7");
    lt_alloc_fail_at(1);
    name = lt_name(set, "%s.%d", longest, 8);
    lt_alloc_fail_at(0);
    ck_assert_str_eq(name, "");
    lt_linear_layer_new(set, name, 5, 7, true);
    ck_assert_int_eq(lt_params_status(set), LT_ENOMEM);
    ck_assert_str_eq(lt_last_error(), "no memory for the name of a parameter");
    ck_assert_ptr_null(lt_params_first(set));
}
END_TEST

START_TEST(nothing_is_without_values)
{
    static const int reduction[] = { 0, -1, 17 };

    lt_se_layer_new(set, "se", 16, reduction[_i]);
    ck_assert_int_eq(lt_params_status(set), LT_ESHAPE);
    ck_assert_str_eq(lt_last_error(), "parameter \"se.fc1.weight\" is (0, 16), want at least one value");
}
END_TEST

static void moments(const lt_param *p, double *mean, double *deviation)
{
    double sum = 0, squares = 0;
    const double n = (double)lt_param_numel(p);

    for (int64_t i = 0; i < lt_param_numel(p); i++) {
        sum += p->data[i];
        squares += (double)p->data[i] * p->data[i];
    }
    *mean = sum / n;
    *deviation = sqrt(squares / n - *mean * *mean);
}

START_TEST(draws_have_the_promised_spread)
{
    lt_param *p = lt_params_add(set, "fc", "weight", LT_WEIGHT, LT_SHAPE(200, 100));
    double mean, deviation;

    lt_init_normal(p, 1, 0.5);
    moments(p, &mean, &deviation);
    ck_assert_double_eq_tol(mean, 0, 0.015);
    ck_assert_double_eq_tol(deviation, 0.5, 0.01);
    lt_init_default(set, 1);                            /* uniform in +-1 / sqrt(100) */
    moments(p, &mean, &deviation);
    ck_assert_double_eq_tol(deviation, 0.1 / sqrt(3), 0.001);
    for (int64_t i = 0; i < lt_param_numel(p); i++)
        ck_assert(fabs(p->data[i]) <= 0.1);
    ck_assert(lt_fan_in(p) == 100 && lt_fan_out(p) == 200);
}
END_TEST

START_TEST(norms_start_as_the_identity)
{
    const lt_batch_norm_layer bn = lt_batch_norm_layer_new(set, "bn", 3);

    lt_init_default(set, 1);
    for (int i = 0; i < 3; i++)
        ck_assert(bn.weight->data[i] == 1 && bn.bias->data[i] == 0 && bn.running_mean->data[i] == 0
                  && bn.running_var->data[i] == 1);
}
END_TEST

/* Draws belong to the name: what else is in the set, and in which order, does not matter. */
START_TEST(draws_do_not_depend_on_order)
{
    lt_params *other = lt_params_new();
    const lt_linear_layer a = lt_linear_layer_new(set, "a", 4, 5, true), b = lt_linear_layer_new(set, "b", 4, 5, true);
    const lt_linear_layer b2 = lt_linear_layer_new(other, "b", 4, 5, true);

    lt_init_default(set, 9);
    lt_init_default(other, 9);
    ck_assert(memcmp(b.weight->data, b2.weight->data, 20 * sizeof(lt_real)) == 0);
    ck_assert(memcmp(b.bias->data, b2.bias->data, 5 * sizeof(lt_real)) == 0);
    ck_assert(memcmp(a.weight->data, b.weight->data, 20 * sizeof(lt_real)) != 0);
    lt_init_default(other, 10);
    ck_assert(memcmp(b.weight->data, b2.weight->data, 20 * sizeof(lt_real)) != 0);
    lt_params_free(other);
}
END_TEST

/* x times sigmoid(w2 relu(w1 mean(x))), by hand for two channels. */
START_TEST(squeeze_and_excitation)
{
    const lt_se_layer se = lt_se_layer_new(set, "se", 2, 2);
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 4, (int64_t[]){ 1, 2, 1, 2 });
    lt_tensor *y = lt_output(lt_se_layer_forward(&se, x), "y");
    lt_plan *p = lt_compile(g, NULL);
    const lt_real in[] = { 1, 3, -2, 4 };               /* means 2 and 1 */

    memcpy(se.fc1.weight->data, (lt_real[]){ 1, -0.5f }, 2 * sizeof(lt_real));
    memcpy(se.fc2.weight->data, (lt_real[]){ 1, -2 }, 2 * sizeof(lt_real));
    lt_plan_refresh(p);
    memcpy(lt_plan_data(p, x), in, sizeof(in));
    lt_run(p);
    for (int i = 0; i < 4; i++)
        ck_assert_double_eq_tol(((lt_real *)lt_plan_data(p, y))[i],
                                in[i] / (1 + exp(i < 2 ? -1.5 : 3)), 1e-6);
    lt_plan_free(p);
    lt_graph_free(g);
}
END_TEST

/* A map's positions in rows and back; on rows a 1 x 1 convolution is what it is on the map. */
START_TEST(tokens_are_a_maps_positions)
{
    const lt_conv_layer conv = lt_conv_layer_new(set, "conv", 3, 2, 1, true, NULL);
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 4, (int64_t[]){ 2, 3, 2, 4 });
    lt_tensor *tokens = lt_output(lt_map_to_tokens(x), "tokens");
    lt_tensor *rows = lt_output(lt_tokens_to_map(lt_conv_layer_on_rows(&conv, tokens), 2, 4), "rows");
    lt_tensor *map = lt_output(lt_conv_layer_forward(&conv, x), "map");
    lt_plan *p = lt_compile(g, NULL);
    lt_real *in = lt_plan_data(p, x);

    lt_init_default(set, 3);
    lt_plan_refresh(p);
    for (int i = 0; i < 48; i++)
        in[i] = (lt_real)i;
    lt_run(p);
    for (int i = 0; i < 48; i++)                        /* token t of image b, channel c */
        ck_assert(((lt_real *)lt_plan_data(p, tokens))[i] == i / 24 * 24 + i % 3 * 8 + i % 24 / 3);
    for (int i = 0; i < 32; i++)
        ck_assert_double_eq_tol(((lt_real *)lt_plan_data(p, rows))[i], ((lt_real *)lt_plan_data(p, map))[i], 1e-5);
    lt_plan_free(p);
    lt_graph_free(g);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_test(tc, layers_register_what_pytorch_calls_them);
    tcase_add_test(tc, names_are_taken_once);
    tcase_add_test(tc, names_are_never_cut);
    tcase_add_loop_test(tc, nothing_is_without_values, 0, 3);
    tcase_add_test(tc, draws_have_the_promised_spread);
    tcase_add_test(tc, norms_start_as_the_identity);
    tcase_add_test(tc, draws_do_not_depend_on_order);
    tcase_add_test(tc, tokens_are_a_maps_positions);
    tcase_add_test(tc, squeeze_and_excitation);
}

int main(void)
{
    return run_suite("nn", add_tests);
}
