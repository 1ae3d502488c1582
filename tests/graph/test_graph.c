/* SPDX-License-Identifier: Apache-2.0 */
/* Recording, compiling and running: errors, passes, views, memory, gradients, randomness. */
#include "tests/graph/graphs.h"

#include "libtensor/optim/optim.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- mistakes ------------------------------------------------------------------------------------- */

START_TEST(the_first_mistake_is_kept)
{
    const lt_conv_layer conv = lt_conv_layer_new(set, "fpn.lateral", 4, 8, 1, true, NULL);
    lt_tensor *x = input("x", LT_SHAPE(1, 3, 5, 5)), *y;
    char want[128];

    y = lt_conv_layer_forward(&conv, x); const int line = __LINE__;
    y = lt_relu(lt_add(y, lt_reshape(x, LT_SHAPE(7))));
    lt_output(y, "y");
    ck_assert_ptr_null(lt_compile(g, NULL));
    snprintf(want, sizeof(want), "conv2d \"fpn.lateral\": input has 3 channels, weight wants 4 (%s:%d)", __FILE__,
             line);
    ck_assert_str_eq(lt_last_error(), want);
    ck_assert_int_eq(lt_graph_status(g), LT_ESHAPE);
}
END_TEST

static lt_status infer_bare(lt_call *c)
{
    return lt_want_rank(c, 0, "input", 2);
}

static void forward_bare(const lt_call *c)
{
    memcpy(c->out->data, c->in[0]->data, lt_nbytes(c->out));
}

static const lt_op bare_op = { .name = "bare", .infer = infer_bare, .forward = forward_bare };

/* An op without LT_HERE does not blame the last call that had it. */
START_TEST(a_place_that_is_not_known)
{
    lt_tensor *x = lt_input(g, "x", LT_F32, 1, (int64_t[]){ 3 });

    lt_relu(x);
    lt_apply(&bare_op, NULL, 0, &x, 1);
    ck_assert_int_eq(lt_graph_status(g), LT_ESHAPE);
    ck_assert_str_eq(lt_last_error(), "bare: input is (3), want 2 dimensions");
    ck_assert_int_eq(lt_last_status(), LT_ESHAPE);
}
END_TEST

/* ---- ops of one's own that lack something --------------------------------------------------------------- */

static lt_status infer_same(lt_call *c)
{
    c->out->shape = c->in[0]->shape;
    return LT_OK;
}

static lt_status infer_nothing(lt_call *c)
{
    (void)c;
    return LT_OK;
}

static void check_refused(lt_graph *of, const char *words)
{
    ck_assert_ptr_null(lt_compile(of, NULL));
    ck_assert_msg(strstr(lt_last_error(), words) != NULL, "\"%s\" does not say \"%s\"", lt_last_error(), words);
}

START_TEST(ops_that_are_not_whole)
{
    static const struct { lt_op op; const char *words; } cases[] = {
        { { .name = "half", .forward = forward_bare }, "half: an op without a shape rule (infer)" },
        { { .name = "half", .infer = infer_same }, "half: an op without forward" },
        { { .infer = infer_same, .forward = forward_bare }, "an op without a name" },
        { { .name = "half", .infer = infer_nothing, .forward = forward_bare },
          "half: its shape rule set no shape for result 0" },
    };
    lt_tensor *x = lt_input(g, "x", LT_F32, 1, (int64_t[]){ 3 });

    lt_output(lt_apply(&cases[_i].op, NULL, 0, &x, 1), "y");
    check_refused(g, cases[_i].words);
}
END_TEST

/* Between the loss and a weight it would cut the gradient in silence; beside that way, or detached, it may stand. */
START_TEST(an_op_without_backward)
{
    static const lt_op copy_op = { .name = "copy", .infer = infer_same, .forward = forward_bare };
    lt_param *w = lt_params_add(set, "layer", "w", LT_WEIGHT, LT_SHAPE(3));
    lt_tensor *x = lt_input(g, "x", LT_F32, 1, (int64_t[]){ 3 }), *used = lt_use(g, w), *product = lt_mul(x, used), *y;

    if (_i == 1)
        product = lt_detach(product);
    y = lt_apply(&copy_op, NULL, 0, &product, 1);
    lt_output(y, "y");
    if (_i == 2)
        y = lt_mul(x, used);
    else
        y = lt_add(y, used);
    lt_plan *p = lt_compile(g, &(lt_compile_opts){ .loss = lt_sum(y), .train = true });
    if (_i == 0) {
        ck_assert_ptr_null(p);
        ck_assert_ptr_nonnull(strstr(lt_last_error(),
                                     "copy: the loss depends on what it reads, and it has no backward"));
    } else {
        ck_assert_msg(p != NULL, "%s", lt_last_error());
    }
    lt_plan_free(p);
}
END_TEST

/* What has no tensor has no graph that could keep the mistake: the next plan on the thread tells it, once. */
START_TEST(tensors_that_are_not_there)
{
    lt_tensor *y = lt_output(lt_relu(NULL), "y"); const int line = __LINE__;
    char want[128];

    ck_assert_ptr_null(y);
    ck_assert_ptr_null(lt_want_grad(NULL));
    ck_assert_ptr_null(lt_result(NULL, 1));
    ck_assert_ptr_null(lt_input(NULL, "x", LT_F32, 0, NULL));
    snprintf(want, sizeof(want), "relu: no input is there (%s:%d)", __FILE__, line);
    check_refused(g, want);
    lt_output(lt_relu(lt_input(g, "x", LT_F32, 1, (int64_t[]){ 3 })), "y");
    lt_plan *p = lt_compile(g, NULL);
    ck_assert_msg(p != NULL, "%s", lt_last_error());
    lt_plan_free(p);
    check_refused(NULL, "there is no graph to compile");
}
END_TEST

START_TEST(scopes_name_layers_without_parameters)
{
    lt_scope(g, "head");
    lt_softmax(lt_scalar(g, 1));
    ck_assert_ptr_null(lt_compile(g, NULL));
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "softmax \"head\": its input is a single number"));
}
END_TEST

START_TEST(inputs_of_impossible_size)
{
    input("x", LT_SHAPE(3, -1));
    ck_assert_int_eq(lt_graph_status(g), LT_ESHAPE);
    ck_assert_str_eq(lt_last_error(), "input \"x\" is (3, -1), which no memory holds");
}
END_TEST

START_TEST(products_of_sizes_that_overflow)
{
    const int64_t huge = INT64_C(1) << 33;

    input("x", LT_SHAPE(huge, huge));
    ck_assert_int_eq(lt_graph_status(g), LT_ESHAPE);
}
END_TEST

START_TEST(whole_numbers_are_no_real_ones)
{
    lt_tensor *index = lt_input(g, "index", LT_I32, 1, (int64_t[]){ 3 });

    lt_sigmoid(lt_reshape(index, LT_SHAPE(3, 1)));
    ck_assert_int_eq(lt_graph_status(g), LT_ESHAPE);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "sigmoid: input 0 holds whole numbers, want real ones"));
}
END_TEST

START_TEST(tensors_of_two_graphs)
{
    lt_graph *other = lt_graph_new();
    lt_tensor *y = lt_input(other, "y", LT_F32, 1, (int64_t[]){ 3 });

    lt_add(input("x", LT_SHAPE(3)), y);
    ck_assert_int_eq(lt_graph_status(g), LT_ESHAPE);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "add: input 1 belongs to another graph"));
    lt_graph_free(other);
}
END_TEST

START_TEST(losses_that_cannot_be)
{
    lt_tensor *x = input("x", LT_SHAPE(3));

    ck_assert_ptr_null(lt_compile(g, &(lt_compile_opts){ .train = true }));
    ck_assert_str_eq(lt_last_error(), "a training plan needs a loss");
    ck_assert_ptr_null(lt_compile(g, &(lt_compile_opts){ .loss = x }));
    ck_assert_str_eq(lt_last_error(), "the loss is (3), want one number");
    ck_assert_ptr_null(lt_compile(g, &(lt_compile_opts){ .train = true, .loss = lt_scalar(g, 1) }));
    ck_assert_str_eq(lt_last_error(), "the loss is \"constant\" itself, want a result");
    x = lt_reshape(input("one", LT_SHAPE(1)), (lt_shape){ 0 });
    ck_assert_ptr_null(lt_compile(g, &(lt_compile_opts){ .train = true, .loss = x }));
    ck_assert_str_eq(lt_last_error(), "the loss is \"one\" itself, want a result");
}
END_TEST

START_TEST(a_loss_of_another_graph)
{
    lt_graph *other = lt_graph_new();
    lt_tensor *x = input("x", LT_SHAPE(3));
    lt_tensor *y = lt_input(other, "y", LT_F32, 1, (int64_t[]){ 3 });

    ck_assert_ptr_null(lt_compile(other, &(lt_compile_opts){ .train = true, .loss = lt_sum(x) }));
    ck_assert_str_eq(lt_last_error(), "the loss belongs to another graph");
    ck_assert_ptr_null(lt_compile(other, &(lt_compile_opts){ .train = true, .loss = lt_sum(lt_add(x, y)) }));
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "add: input 1 belongs to another graph"));
    lt_graph_free(other);
}
END_TEST

START_TEST(a_plan_knows_its_own_tensors)
{
    lt_graph *other = lt_graph_new();
    lt_tensor *x = input("x", LT_SHAPE(3)), *loss = lt_sum(x), *later;
    lt_tensor *y = lt_input(other, "y", LT_F32, 1, (int64_t[]){ 3 });
    lt_plan *p = lt_compile(g, &(lt_compile_opts){ .loss = loss });

    for (int i = 0; i < 40; i++)
        later = lt_output(lt_relu(x), "later");
    ck_assert_ptr_nonnull(lt_plan_data(p, x));
    ck_assert_ptr_null(lt_plan_data(p, later));
    ck_assert_ptr_null(lt_plan_data(p, y));
    ck_assert_ptr_null(lt_plan_grad(p, later));
    lt_plan_free(p);
    lt_graph_free(other);
}
END_TEST

START_TEST(parameters_that_cannot_be)
{
    lt_param *twice;

    lt_params_add(set, "", "a", LT_WEIGHT, LT_SHAPE(2));
    twice = lt_params_add(set, "", "a", LT_WEIGHT, LT_SHAPE(2));
    lt_mul(input("x", LT_SHAPE(2)), lt_use(g, twice));
    ck_assert_ptr_null(lt_compile(g, NULL));
    ck_assert_str_eq(lt_last_error(), "parameter \"a\" is registered twice");
}
END_TEST

START_TEST(parameters_of_impossible_size)
{
    lt_params_add(set, "", "a", LT_WEIGHT, LT_SHAPE(INT64_C(1) << 33, INT64_C(1) << 31));
    ck_assert_int_eq(lt_params_status(set), LT_ESHAPE);
    ck_assert_str_eq(lt_last_error(), "parameter \"a\" is (8589934592, 2147483648), which no memory holds");
    lt_constant(g, LT_F32, LT_SHAPE(INT64_C(1) << 33, INT64_C(1) << 31), NULL);
    ck_assert_int_eq(lt_graph_status(g), LT_ESHAPE);
}
END_TEST

/* ---- constants ------------------------------------------------------------------------------------ */

START_TEST(constants_are_filled_in_place)
{
    lt_tensor *k, *nothing, *x, *y;
    lt_real *v = lt_constant_reals(g, LT_SHAPE(2, 2), &k);
    lt_plan *p;

    for (int i = 0; i < 4; i++) {
        ck_assert(v[i] == 0);
        v[i] = (lt_real)i;
    }
    ck_assert_ptr_nonnull(lt_constant_reals(g, LT_SHAPE(0, 2), &nothing));
    ck_assert_int_eq(lt_numel(nothing), 0);
    x = input("x", LT_SHAPE(2, 2));
    y = lt_output(lt_mul(x, k), "y");
    p = lt_compile(g, NULL);
    fill(p, x, 1);
    lt_run(p);
    for (int i = 0; i < 4; i++)
        ck_assert(at(p, y, i) == at(p, x, i) * (lt_real)i);
    lt_plan_free(p);
}
END_TEST

/* After a mistake there is nothing to fill, and what is recorded with it is harmless. */
START_TEST(constants_that_are_refused)
{
    lt_tensor *k;

    ck_assert_ptr_null(lt_constant_reals(g, LT_SHAPE(-1), &k));
    ck_assert_int_eq(lt_graph_status(g), LT_ESHAPE);
    ck_assert_str_eq(lt_last_error(), "a constant is (-1), which no memory holds");
    lt_relu(k);
    ck_assert_ptr_null(lt_constant_reals(g, LT_SHAPE(3), &k));
    ck_assert_ptr_eq(lt_cell_places(g, 2, 2), k);
    ck_assert_str_eq(lt_last_error(), "a constant is (-1), which no memory holds");
}
END_TEST

/* 100 x 100 cells are a block of their own in the graph's arena. */
START_TEST(constants_without_memory)
{
    lt_cell_places(g, 1, 1);
    lt_alloc_fail_at(1);
    lt_output(lt_relu(lt_cell_places(g, 100, 100)), "y");
    lt_alloc_fail_at(0);
    ck_assert_int_eq(lt_graph_status(g), LT_ENOMEM);
    ck_assert_str_eq(lt_last_error(), "no memory for a constant");
}
END_TEST

/* ---- passes --------------------------------------------------------------------------------------- */

START_TEST(dead_code_goes)
{
    lt_tensor *x = input("x", LT_SHAPE(3));
    lt_plan *p;

    lt_sigmoid(lt_tanh(x));
    lt_output(lt_gelu(x), "y");
    p = lt_compile(g, NULL);
    ck_assert_int_eq(lt_plan_steps(p), 1);
    lt_plan_free(p);
}
END_TEST

START_TEST(constants_are_folded_and_refreshed)
{
    lt_param *w = lt_params_add(set, "", "w", LT_WEIGHT, LT_SHAPE(2));
    lt_tensor *x = input("x", LT_SHAPE(2)), *y = lt_output(lt_add(x, lt_scale(lt_use(g, w), 3)), "y");
    lt_plan *p;

    w->data[0] = 1;
    p = lt_compile(g, NULL);
    ck_assert_int_eq(lt_plan_steps(p), 1);
    lt_run(p);
    ck_assert(at(p, y, 0) == 3);
    w->data[0] = 2;
    lt_plan_refresh(p);
    lt_run(p);
    ck_assert(at(p, y, 0) == 6);
    lt_plan_free(p);
}
END_TEST

/* x doubled 60 times, and 60 cheap diamonds: found out in a moment, not in 2^60 of them. */
START_TEST(diamonds_take_no_longer_than_chains)
{
    lt_param *w = lt_params_add(set, "", "w", LT_WEIGHT, LT_SHAPE(2));
    lt_tensor *x = lt_use(g, w), *y = lt_tanh(x);
    lt_plan *p;

    for (int i = 0; i < 60; i++) {
        x = lt_add(x, x);
        y = lt_concat((lt_tensor *[]){ lt_slice(y, 0, 0, 1), lt_slice(y, 0, 1, 1) }, 2, 0);
    }
    lt_output(x, "x");
    lt_output(y, "y");
    p = lt_compile(g, NULL);
    ck_assert_int_eq(lt_plan_steps(p), 0);
    lt_plan_free(p);
    p = lt_compile(g, &(lt_compile_opts){ .train = true, .loss = lt_sum(lt_mul(x, y)) });
    ck_assert_ptr_nonnull(p);
    lt_plan_free(p);
}
END_TEST

/* ---- views, readers, gradients --------------------------------------------------------------------- */

START_TEST(views_share_values_and_gradients)
{
    lt_tensor *x = lt_want_grad(input("x", LT_SHAPE(2, 3)));
    lt_tensor *v = lt_reshape(lt_reshape(x, LT_SHAPE(6)), LT_SHAPE(3, 2)), *loss;
    lt_plan *p;

    lt_output(v, "v");
    loss = lt_add(lt_sum(lt_mul(v, v)), lt_sum(lt_mul(x, lt_detach(x))));
    p = lt_compile(g, &(lt_compile_opts){ .loss = loss, .train = true });
    fill(p, x, 1);
    lt_run(p);
    ck_assert_ptr_eq(lt_plan_data(p, v), lt_plan_data(p, x));
    ck_assert_ptr_null(lt_plan_grad(p, v));
    for (int i = 0; i < 6; i++)                         /* 2 x from the square, x beside the detached */
        ck_assert_double_eq_tol(lt_plan_grad(p, x)[i], 3 * at(p, x, i), 1e-6);
    lt_plan_free(p);
}
END_TEST

START_TEST(gradients_reach_what_the_loss_reads)
{
    lt_param *a = lt_params_add(set, "", "a", LT_WEIGHT, LT_SHAPE(2));
    lt_param *b = lt_params_add(set, "", "b", LT_WEIGHT, LT_SHAPE(2));
    lt_param *frozen = lt_params_add(set, "", "frozen", LT_WEIGHT, LT_SHAPE(2));
    lt_tensor *x = input("x", LT_SHAPE(2)), *loss;
    lt_plan *p;

    frozen->frozen = true;
    lt_output(lt_mul(x, lt_use(g, b)), "beside");
    loss = lt_sum(lt_mul(lt_mul(x, lt_use(g, a)), lt_use(g, frozen)));
    p = lt_compile(g, &(lt_compile_opts){ .loss = loss, .train = true });
    ck_assert_ptr_nonnull(a->grad);
    ck_assert_ptr_null(b->grad);
    ck_assert_ptr_null(frozen->grad);
    frozen->data[0] = 2;
    ((lt_real *)lt_plan_data(p, x))[0] = 5;
    lt_run(p);
    lt_plan_set_loss_weight(p, 0.5);
    lt_run(p);
    ck_assert(a->grad[0] == 15);                        /* runs add up */
    lt_params_zero_grad(set);
    ck_assert(a->grad[0] == 0);
    lt_plan_free(p);
}
END_TEST

/* A training plan may have nothing that learns. */
START_TEST(a_detached_loss)
{
    lt_param *a = lt_params_add(set, "", "a", LT_WEIGHT, LT_SHAPE(2));
    lt_tensor *loss = lt_detach(lt_sum(lt_use(g, a)));
    lt_plan *p = lt_compile(g, &(lt_compile_opts){ .loss = loss, .train = true });

    a->data[0] = 3;
    lt_run(p);
    ck_assert(at(p, loss, 0) == 3);
    ck_assert_ptr_null(a->grad);
    lt_plan_free(p);
}
END_TEST

/* Whatever the gradients were, also of what is read twice, and of what an op reads that only adds */
START_TEST(gradients_are_replaced)
{
    enum { C = 5, MOST = 1000 };
    static lt_real grads[2][MOST];
    const lt_conv_layer conv = lt_conv_layer_new(set, "conv", C, C, 3, true, &(lt_conv_opts){ .pad = 1 });
    const lt_batch_norm_layer bn = lt_batch_norm_layer_new(set, "bn", C);
    const lt_linear_layer fc = lt_linear_layer_new(set, "fc", C, C, true);
    lt_param *turn = lt_params_add(set, "", "turn", LT_WEIGHT, LT_SHAPE(C, C));
    lt_tensor *x = lt_want_grad(input("x", LT_SHAPE(2, C, 4, 4))), *y, *loss;
    lt_plan *adds, *replaces;
    int64_t n;

    lt_init_default(set, 3);
    lt_init_uniform(turn, 5, 1);
    y = lt_batch_norm_layer_forward(&bn, lt_conv_layer_forward(&conv, lt_tanh(lt_conv_layer_forward(&conv, x))));
    y = lt_matmul(lt_global_avg_pool(y), lt_use(g, turn));
    y = lt_add(lt_linear_layer_forward(&fc, y), lt_use(g, fc.bias));
    loss = lt_sum(lt_mul(y, lt_tanh(y)));
    adds = lt_compile(g, &(lt_compile_opts){ .train = true, .loss = loss });
    replaces = lt_compile(g, &(lt_compile_opts){ .train = true, .loss = loss, .replace_grads = true });
    fill(adds, x, 1);
    fill(replaces, x, 1);
    n = run_for_gradients(adds, x, grads[0]);
    ck_assert_int_le(n, MOST);
    for (const lt_param *p = lt_params_first(set); p; p = p->next)
        for (int64_t i = 0; i < lt_param_numel(p); i++)
            p->grad[i] = (lt_real)NAN;
    ck_assert_int_eq(run_for_gradients(replaces, x, grads[1]), n);
    for (int64_t i = 0; i < n; i++)
        ck_assert(grads[0][i] == grads[1][i]);
    lt_plan_free(adds);
    lt_plan_free(replaces);
}
END_TEST

/* y = relu(x) may take x's place only where nobody needs x. */
START_TEST(nothing_is_overwritten_that_is_still_read)
{
    lt_tensor *x = input("x", LT_SHAPE(5)), *h = lt_scale(x, 2), *r = lt_relu(h), *y;
    lt_plan *p;

    y = lt_output(lt_add(lt_scale(r, 3), h), "y");
    lt_output(r, "r");
    p = lt_compile(g, NULL);
    fill(p, x, 1);
    for (int run = 0; run < 2; run++) {
        lt_run(p);
        for (int i = 0; i < 5; i++) {
            const lt_real v = 2 * at(p, x, i), relu = v > 0 ? v : 0;

            ck_assert(at(p, r, i) == relu);
            ck_assert_double_eq_tol(at(p, y, i), 3 * relu + v, 1e-6);
        }
    }
    lt_plan_free(p);
}
END_TEST

/* Pieces that stand in their whole: read after it was put together, put together twice, with something made of them. */
START_TEST(pieces_of_a_whole)
{
    enum { N = 64 };
    lt_tensor *x = input("x", LT_SHAPE(3, N)), *a = lt_relu(x), *cut = lt_slice(a, 0, 1, 1);
    lt_tensor *tall = lt_sigmoid(lt_slice(a, 0, 2, 1));
    lt_tensor *y = lt_concat((lt_tensor *[]){ tall, a, cut, tall }, 4, 0);
    lt_tensor *z = lt_concat((lt_tensor *[]){ lt_relu(y), tall, y }, 3, 0);
    lt_plan *p;

    lt_output(z, "z");
    lt_output(lt_add(cut, tall), "sum");
    p = compile_filled(x, NULL);
    for (int run = 0; run < 2; run++) {
        lt_run(p);
        for (int i = 0; i < N; i++) {
            const double in[3] = { fmax(0, at(p, x, i)), fmax(0, at(p, x, N + i)), fmax(0, at(p, x, 2 * N + i)) };
            const double s = 1 / (1 + exp(-in[2])), want[6] = { s, in[0], in[1], in[2], in[1], s };

            for (int k = 0; k < 13; k++)
                ck_assert_double_eq_tol(at(p, z, k * N + i), k == 6 ? s : want[k < 6 ? k : k - 7], 1e-6);
        }
    }
    lt_plan_free(p);
}
END_TEST

/* Behind a frozen convolution that is computed within a region alone, a layer learns: what multiplies the rest's
 * gradient of 0 is no infinity that the memory held. */
START_TEST(a_frozen_region_leaves_nothing_behind)
{
    enum { C = 8, H = 16, CELLS = C * H * H };
    static lt_real mask[CELLS], target[CELLS];
    lt_tensor *x = input("x", LT_SHAPE(1, C, H, H)), *boxes = input("boxes", LT_SHAPE(1, 5)), *logits, *region, *y;
    lt_param *w = lt_params_add(set, "a", "weight", LT_WEIGHT, LT_SHAPE(C, C, 3, 3));
    lt_param *w2 = lt_params_add(set, "b", "weight", LT_WEIGHT, LT_SHAPE(C, C, 1, 1));
    const lt_real box[] = { 0, 5, 5, 9, 9 };
    lt_plan *p;

    w->frozen = true;
    lt_init_uniform(w, 1, 1);
    lt_init_uniform(w2, 2, 1);
    for (int i = 0; i < CELLS; i++) {
        mask[i] = i % 4 == 1 ? -(lt_real)INFINITY : 0;
        target[i] = i % (H * H) == 0;
    }
    logits = lt_add(lt_reshape(x, LT_SHAPE(C, H * H)), lt_constant(g, LT_F32, LT_SHAPE(C, H * H), mask));
    lt_output(lt_cross_entropy(logits, lt_constant(g, LT_F32, LT_SHAPE(C, H * H), target), NULL), "entropy");
    region = lt_box_region(&boxes, 1, 1, H, H, 1, 2);
    y = lt_conv2d_within(x, lt_use(g, w), NULL, &(lt_conv_opts){ .pad = 1 }, region);
    y = lt_roi_align(lt_conv2d(y, lt_use(g, w2), NULL, NULL), boxes, 2, 2, 1);
    p = lt_compile(g, &(lt_compile_opts){ .train = true, .loss = lt_sum(y) });
    ck_assert_msg(p != NULL, "%s", lt_last_error());
    fill(p, x, 1);
    memcpy(lt_plan_data(p, boxes), box, sizeof(box));
    lt_run(p);
    for (int64_t i = 0; i < lt_param_numel(w2); i++)
        ck_assert(isfinite(w2->grad[i]));
    lt_plan_free(p);
}
END_TEST

/* A loss that nobody can know is not 0. */
START_TEST(weights_that_are_no_numbers)
{
    lt_tensor *a = input("a", LT_SHAPE(2, 3)), *b = input("b", LT_SHAPE(2, 3)), *w = input("w", LT_SHAPE(2));
    lt_tensor *loss[] = {
        lt_output(lt_mse_loss(a, b, w), "mse"), lt_output(lt_l1_loss(a, b, w), "l1"),
        lt_output(lt_cross_entropy(a, b, w), "entropy"),
    };
    lt_plan *p = lt_compile(g, NULL);

    ck_assert_msg(p != NULL, "%s", lt_last_error());
    fill(p, a, 1);
    fill(p, b, 2);
    for (int k = 0; k < 2; k++) {
        const lt_real weights[] = { 1, k ? 1 : NAN };

        memcpy(lt_plan_data(p, w), weights, sizeof(weights));
        lt_run(p);
        for (size_t i = 0; i < LT_COUNT(loss); i++)
            ck_assert(isnan(at(p, loss[i], 0)) == !k);
    }
    lt_plan_free(p);
}
END_TEST

START_TEST(results_that_are_not_there)
{
    lt_tensor *x = input("x", LT_SHAPE(2));

    lt_output(lt_result(lt_tanh(x), 1), "y");
    ck_assert_ptr_null(lt_compile(g, NULL));
    ck_assert_str_eq(lt_last_error(), "lt_result: result 1 of tanh, which has 1");
}
END_TEST

START_TEST(the_first_bad_tensor_has_a_name)
{
    lt_param *w = lt_params_add(set, "head.fc", "weight", LT_WEIGHT, LT_SHAPE(2, 2));
    lt_tensor *x = input("x", LT_SHAPE(1, 2)), *loss = lt_sum(lt_tanh(lt_linear(x, lt_use(g, w), NULL)));
    lt_plan *p = lt_compile(g, &(lt_compile_opts){ .loss = loss, .train = true });
    char where[64];

    lt_plan_find_nonfinite(p, where, sizeof(where));
    ck_assert_str_eq(where, "");
    w->data[0] = NAN;
    lt_plan_find_nonfinite(p, where, sizeof(where));
    ck_assert_str_eq(where, "linear \"head.fc\"");
    w->data[0] = 0;
    lt_plan_set_loss_weight(p, INFINITY);
    lt_plan_find_nonfinite(p, where, sizeof(where));
    ck_assert_str_eq(where, "sum after \"head.fc\" (gradient)");
    lt_plan_free(p);
}
END_TEST

/* ---- infinities, NaNs, large windows ---------------------------------------------------------------- */

/* A NaN is the largest of its windows, and takes their gradient. */
START_TEST(a_nan_wins_its_windows)
{
    lt_tensor *x = lt_want_grad(input("x", LT_SHAPE(1, 1, 2, 4)));
    lt_tensor *y = lt_output(lt_max_pool2d(x, 2, 2, 0, false), "y");
    lt_plan *p = lt_compile(g, &(lt_compile_opts){ .loss = lt_sum(y), .train = true });

    memcpy(lt_plan_data(p, x), (lt_real[]){ 1, NAN, 3, 4, 9, 2, 8, 5 }, 8 * sizeof(lt_real));
    lt_run(p);
    ck_assert(isnan(at(p, y, 0)) && at(p, y, 1) == 8);
    for (int i = 0; i < 8; i++)
        ck_assert(lt_plan_grad(p, x)[i] == (i == 1 || i == 6));
    lt_plan_free(p);
}
END_TEST

/* Alone, and behind a convolution */
START_TEST(relu_of_minus_infinity)
{
    const lt_conv_layer conv = lt_conv_layer_new(set, "conv", 1, 1, 1, false, NULL);
    lt_tensor *x = input("x", LT_SHAPE(1, 1, 1, 2)), *alone = lt_output(lt_relu(x), "alone");
    lt_tensor *behind = lt_output(lt_relu(lt_conv_layer_forward(&conv, x)), "behind");
    lt_plan *p;

    conv.weight->data[0] = 1;
    p = lt_compile(g, NULL);
    ((lt_real *)lt_plan_data(p, x))[0] = -(lt_real)INFINITY;
    lt_run(p);
    ck_assert(at(p, alone, 0) == 0 && at(p, behind, 0) == 0);
    ((lt_real *)lt_plan_data(p, x))[0] = (lt_real)NAN;
    lt_run(p);
    ck_assert(isnan(at(p, alone, 0)) && isnan(at(p, behind, 0)));
    lt_plan_free(p);
}
END_TEST

/* The mean of ones is one, over however many of them. */
START_TEST(roi_align_reads_all_of_a_large_bin)
{
    enum { SIDE = 400 };
    lt_tensor *x = input("x", LT_SHAPE(1, 1, SIDE, SIDE)), *boxes = input("boxes", LT_SHAPE(1, 5));
    lt_tensor *y = lt_output(lt_roi_align(x, boxes, 1, 1, 1), "y");
    lt_plan *p = lt_compile(g, NULL);

    for (int i = 0; i < SIDE * SIDE; i++)
        ((lt_real *)lt_plan_data(p, x))[i] = 1;
    memcpy(lt_plan_data(p, boxes), (lt_real[]){ 0, 0, 0, SIDE, SIDE }, 5 * sizeof(lt_real));
    lt_run(p);
    ck_assert_double_eq_tol(at(p, y, 0), 1, 1e-5);
    lt_plan_free(p);
}
END_TEST

/* ---- randomness ------------------------------------------------------------------------------------ */

START_TEST(dropout_draws_by_step)
{
    enum { N = 40000 };
    lt_tensor *x = lt_want_grad(input("x", LT_SHAPE(N))), *y = lt_output(lt_dropout(x, 0.25), "y");
    lt_plan *p = lt_compile(g, &(lt_compile_opts){ .loss = lt_sum(y), .train = true });
    lt_real *first = malloc(N * sizeof(*first));
    int zeros = 0, other = 0;

    for (int i = 0; i < N; i++)
        ((lt_real *)lt_plan_data(p, x))[i] = 1;
    lt_plan_set_step(p, 1, 10);
    lt_run(p);
    memcpy(first, lt_plan_data(p, y), N * sizeof(*first));
    ck_assert(memcmp(first, lt_plan_grad(p, x), N * sizeof(*first)) == 0);
    lt_plan_set_step(p, 1, 11);
    lt_run(p);
    for (int i = 0; i < N; i++) {
        zeros += first[i] == 0;
        other += first[i] != at(p, y, i);
        ck_assert(first[i] == 0 || fabs(first[i] - 4.0 / 3) < 1e-6);
    }
    ck_assert_int_lt(abs(zeros - N / 4), 400);          /* 4.6 deviations */
    ck_assert_int_lt(abs(other - N * 3 / 8), 500);
    lt_plan_set_step(p, 1, 10);
    lt_run(p);
    ck_assert(memcmp(first, lt_plan_data(p, y), N * sizeof(*first)) == 0);
    lt_plan_free(p);
    free(first);
}
END_TEST

START_TEST(stochastic_depth_draws_by_sample)
{
    enum { N = 10000, EACH = 3 };
    lt_tensor *x = lt_want_grad(input("x", LT_SHAPE(N, EACH)));
    lt_tensor *y = lt_output(lt_stochastic_depth(x, 0.25), "y");
    lt_plan *p = lt_compile(g, &(lt_compile_opts){ .loss = lt_sum(y), .train = true });
    int zeros = 0;

    for (int i = 0; i < N * EACH; i++)
        ((lt_real *)lt_plan_data(p, x))[i] = 1;
    lt_run(p);
    for (int i = 0; i < N; i++) {
        zeros += at(p, y, EACH * i) == 0;
        ck_assert(at(p, y, EACH * i) == 0 || fabs(at(p, y, EACH * i) - 4.0 / 3) < 1e-6);
        for (int k = 1; k < EACH; k++)
            ck_assert(at(p, y, EACH * i + k) == at(p, y, EACH * i));
    }
    ck_assert_int_lt(abs(zeros - N / 4), 200);          /* 4.6 deviations */
    lt_plan_free(p);
}
END_TEST

/* ---- the memory plan ------------------------------------------------------------------------------- */

enum { LAYERS = 24 };

/* With statistics that anything may have made */
static lt_tensor *normalised(lt_tensor *x, lt_tensor *a)
{
    lt_tensor *row = lt_reshape(lt_slice(a, 0, 1, 1), LT_SHAPE(6));

    return lt_batch_norm(x, row, lt_tanh(row), lt_scale(row, 0.3), lt_sigmoid(row), 1e-3);
}

/* A random graph of ops on (4, 6), in-place ones, cheap ones, views and many readers among them. */
static lt_tensor *random_graph(lt_rng *r, lt_tensor *x, lt_tensor **made)
{
    lt_tensor *t[LAYERS + 1] = { x };

    for (int i = 1; i <= LAYERS; i++) {
        lt_tensor *a = t[lt_rng_below(r, (uint32_t)i)], *b = t[i - 1 - (int)lt_rng_below(r, (uint32_t)(i < 4 ? i : 4))];

        switch (lt_rng_below(r, 11)) {
        case 0: t[i] = lt_add(a, b); break;
        case 1: t[i] = lt_mul(b, lt_sigmoid(a)); break;
        case 2: t[i] = lt_leaky_relu(b, 0.1); break;
        case 3: t[i] = lt_reshape(lt_scale(lt_reshape(b, LT_SHAPE(24)), 0.7), LT_SHAPE(4, 6)); break;
        case 4: t[i] = lt_concat((lt_tensor *[]){ lt_slice(b, 0, 1, 3), lt_slice(a, 0, 0, 1) }, 2, 0); break;
        case 5: t[i] = lt_softmax(b); break;
        case 6: t[i] = lt_tanh(lt_sub(a, b)); break;
        case 7: t[i] = normalised(b, a); break;
        case 8: t[i] = lt_leaky_relu(lt_add(normalised(b, b), a), 0.2); break;
        case 9: t[i] = lt_silu(normalised(b, a)); break;
        default: t[i] = lt_dropout(b, 0.2); break;
        }
        made[i - 1] = t[i];
    }
    return lt_sum(lt_mul(t[LAYERS], lt_tanh(t[LAYERS / 2])));
}

typedef struct {
    lt_real loss, grad[24];
} outcome;

/* everything: mark every tensor an output, so that no memory is shared, and nothing fused. */
static outcome run_random(int seed, lt_compile_opts o, bool everything)
{
    lt_rng r = lt_rng_make((uint64_t)seed, 0);
    lt_tensor *x, *made[LAYERS], *loss;
    outcome out = { .loss = 0 };
    lt_plan *p;

    start();
    x = lt_want_grad(input("x", LT_SHAPE(4, 6)));
    loss = random_graph(&r, x, made);
    for (int i = 0; everything && i < LAYERS; i++)
        lt_output(made[i], "made");
    o.loss = loss;
    p = lt_compile(g, &o);
    fill(p, x, 1);
    for (int i = 0; i < 2; i++)
        lt_run(p);
    out.loss = at(p, loss, 0);
    if (o.train)
        memcpy(out.grad, lt_plan_grad(p, x), sizeof(out.grad));
    lt_plan_free(p);
    stop();
    return out;
}

START_TEST(sharing_memory_changes_no_bit)
{
    const lt_compile_opts kept = { .train = true, .no_fusion = true, .no_recompute = true };
    const lt_compile_opts redone = { .train = true, .no_fusion = true };
    const lt_compile_opts fused_kept = { .train = true, .no_recompute = true }, fused_redone = { .train = true };
    const lt_compile_opts infer = { .train = false };
    const outcome alone = run_random(_i, kept, true), shared = run_random(_i, kept, false);
    const outcome again = run_random(_i, redone, false);
    const outcome fused = run_random(_i, fused_kept, false), fused_again = run_random(_i, fused_redone, false);

    ck_assert(memcmp(&alone, &shared, sizeof(alone)) == 0);
    ck_assert(memcmp(&alone, &again, sizeof(alone)) == 0);
    ck_assert(memcmp(&fused, &fused_again, sizeof(fused)) == 0);
    for (int i = 0; i < 24; i++)
        ck_assert_double_eq_tol(fused.grad[i], alone.grad[i], 1e-4 * (1 + fabs((double)alone.grad[i])));
    ck_assert(run_random(_i, infer, true).loss == run_random(_i, infer, false).loss);
}
END_TEST

/* ---- memory that is not there ----------------------------------------------------------------------- */

static lt_plan *record_and_compile(bool train)
{
    lt_params *s = set = lt_params_new();
    lt_conv_layer conv;
    lt_batch_norm_layer bn;
    lt_tensor *x, *loss;

    g = lt_graph_new();
    if (!s || !g)
        return NULL;
    conv = lt_conv_layer_new(s, "conv", 3, 4, 3, true, NULL);
    bn = lt_batch_norm_layer_new(s, "bn", 4);
    if (lt_params_status(s))
        return NULL;
    x = input("x", LT_SHAPE(2, 3, 40, 40));
    loss = lt_sum(lt_relu(lt_batch_norm_layer_forward(&bn, lt_conv_layer_forward(&conv, x))));
    return lt_compile(g, &(lt_compile_opts){ .loss = loss, .train = train });
}

START_TEST(every_allocation_may_fail)
{
    for (int n = 1; n < 1000; n++) {
        lt_plan *p;

        lt_alloc_fail_at(n);
        p = record_and_compile(_i);
        lt_alloc_fail_at(0);
        lt_plan_free(p);
        if (set)
            ck_assert(!lt_params_find(set, "conv.weight") || p || lt_last_error()[0]);
        lt_graph_free(g);
        lt_params_free(set);
        if (p) {
            ck_assert_int_gt(n, 5);
            return;
        }
    }
    ck_abort_msg("never succeeds");
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("graph");
    TCase *tc = tcase_create("one graph"), *many = tcase_create("many graphs");

    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_test(tc, the_first_mistake_is_kept);
    tcase_add_test(tc, a_place_that_is_not_known);
    tcase_add_test(tc, scopes_name_layers_without_parameters);
    tcase_add_loop_test(tc, ops_that_are_not_whole, 0, 4);
    tcase_add_loop_test(tc, an_op_without_backward, 0, 3);
    tcase_add_test(tc, tensors_that_are_not_there);
    tcase_add_test(tc, inputs_of_impossible_size);
    tcase_add_test(tc, products_of_sizes_that_overflow);
    tcase_add_test(tc, whole_numbers_are_no_real_ones);
    tcase_add_test(tc, tensors_of_two_graphs);
    tcase_add_test(tc, losses_that_cannot_be);
    tcase_add_test(tc, a_loss_of_another_graph);
    tcase_add_test(tc, a_plan_knows_its_own_tensors);
    tcase_add_test(tc, parameters_that_cannot_be);
    tcase_add_test(tc, parameters_of_impossible_size);
    tcase_add_test(tc, constants_are_filled_in_place);
    tcase_add_test(tc, constants_that_are_refused);
    tcase_add_test(tc, constants_without_memory);
    tcase_add_test(tc, dead_code_goes);
    tcase_add_test(tc, constants_are_folded_and_refreshed);
    tcase_add_test(tc, diamonds_take_no_longer_than_chains);
    tcase_add_test(tc, views_share_values_and_gradients);
    tcase_add_test(tc, gradients_reach_what_the_loss_reads);
    tcase_add_test(tc, a_detached_loss);
    tcase_add_test(tc, gradients_are_replaced);
    tcase_add_test(tc, nothing_is_overwritten_that_is_still_read);
    tcase_add_test(tc, pieces_of_a_whole);
    tcase_add_test(tc, a_frozen_region_leaves_nothing_behind);
    tcase_add_test(tc, weights_that_are_no_numbers);
    tcase_add_test(tc, results_that_are_not_there);
    tcase_add_test(tc, the_first_bad_tensor_has_a_name);
    tcase_add_test(tc, a_nan_wins_its_windows);
    tcase_add_test(tc, relu_of_minus_infinity);
    tcase_add_test(tc, roi_align_reads_all_of_a_large_bin);
    tcase_add_test(tc, dropout_draws_by_step);
    tcase_add_test(tc, stochastic_depth_draws_by_sample);
    suite_add_tcase(suite, tc);
    tcase_add_loop_test(many, sharing_memory_changes_no_bit, 0, 60);
    tcase_add_loop_test(many, every_allocation_may_fail, 0, 2);
    suite_add_tcase(suite, many);
    return run_tests(suite);
}
