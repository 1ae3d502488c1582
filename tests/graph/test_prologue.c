/* SPDX-License-Identifier: Apache-2.0 */
/* What is computed once, before the runs, is still there in every run. */
#include "libtensor/graph/plan.h"
#include "libtensor/ops/ops.h"
#include "tests/suite.h"

#include <string.h>

enum { N = 64 };

/* y = x^3 k with k = 2 * 5, read only by the last step, when memory of earlier steps is free again. */
START_TEST(constants_last)
{
    lt_real two[N], five[N], *in, *out;
    lt_graph *g = lt_graph_new();
    lt_tensor *x, *k, *y;
    lt_plan *p;

    for (int i = 0; i < N; i++) {
        two[i] = 2;
        five[i] = 5;
    }
    x = lt_input(g, "x", LT_F32, 1, (int64_t[]){ N });
    k = lt_mul(lt_constant(g, LT_F32, LT_SHAPE(N), two), lt_constant(g, LT_F32, LT_SHAPE(N), five));
    y = lt_output(lt_mul(lt_mul(lt_mul(x, x), x), k), "y");
    p = lt_compile(g, NULL);
    ck_assert_ptr_nonnull(p);
    in = lt_plan_data(p, x);
    out = lt_plan_data(p, y);
    for (int run = 1; run <= 3; run++) {
        for (int i = 0; i < N; i++)
            in[i] = (lt_real)run;
        lt_run(p);
        for (int i = 0; i < N; i++)
            ck_assert_double_eq((double)out[i], 10.0 * run * run * run);
    }
    lt_plan_free(p);
    lt_graph_free(g);
}
END_TEST

enum { C = 64, SIDE = 20 };

/* A convolution whose weights are worth giving back: the same bits, and the weights are gone. */
static void convolve(lt_params *set, bool consume, lt_real *out)
{
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_input(g, "x", LT_F32, 4, (int64_t[]){ 1, C, SIDE, SIDE });
    lt_tensor *w = lt_use(g, lt_params_find(set, "w")), *b = lt_use(g, lt_params_find(set, "b"));
    lt_tensor *y = lt_conv2d(lt_conv2d(x, w, b, NULL), lt_use(g, lt_params_find(set, "once")), b, NULL);
    lt_plan *p;

    y = lt_output(lt_conv2d(y, w, b, &(lt_conv_opts){ .pad = 1 }), "y");
    p = lt_compile(g, &(lt_compile_opts){ .consume_params = consume });
    ck_assert_ptr_nonnull(p);
    for (int i = 0; i < lt_numel(x); i++)
        ((lt_real *)lt_plan_data(p, x))[i] = (lt_real)(i % 17 - 8);
    if (consume)
        lt_plan_refresh(p);
    lt_run(p);
    memcpy(out, lt_plan_data(p, y), lt_nbytes(y));
    lt_plan_free(p);
    lt_graph_free(g);
}

START_TEST(packed_parameters_may_go)
{
    enum { OUT = C * (SIDE - 4) * (SIDE - 4) };
    static lt_real kept[OUT], consumed[OUT];
    lt_params *set = lt_params_new();
    lt_param *w = lt_params_add(set, "", "w", LT_WEIGHT, LT_SHAPE(C, C, 3, 3));
    lt_param *once = lt_params_add(set, "", "once", LT_WEIGHT, LT_SHAPE(C, C, 3, 3));
    lt_param *b = lt_params_add(set, "", "b", LT_WEIGHT, LT_SHAPE(C));

    for (int64_t i = 0; i < lt_param_numel(w); i++)
        w->data[i] = (lt_real)(i % 7 - 3) / 64, once->data[i] = (lt_real)(i % 5 - 2) / 64;
    for (int i = 0; i < C; i++)
        b->data[i] = (lt_real)i;
    convolve(set, false, kept);
    convolve(set, true, consumed);
    ck_assert(memcmp(kept, consumed, sizeof(kept)) == 0);
    ck_assert(w->data[lt_param_numel(w) / 2] == 0 && once->data[lt_param_numel(once) / 2 + 1] == 0);
    ck_assert(b->data[5] == 5);                         /* every run reads it */
    lt_params_free(set);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_test(t, constants_last);
    tcase_add_test(t, packed_parameters_may_go);
}

int main(void)
{
    return run_suite("prologue", add_tests);
}
