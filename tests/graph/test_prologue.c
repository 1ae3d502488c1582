/* SPDX-License-Identifier: Apache-2.0 */
/* What is computed once, before the runs, is still there in every run. */
#include "libtensor/graph/plan.h"
#include "libtensor/ops/ops.h"

#include <check.h>
#include <stdlib.h>

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

int main(void)
{
    TCase *t = tcase_create("prologue");
    Suite *s = suite_create("prologue");
    SRunner *r;
    int failed;

    tcase_add_test(t, constants_last);
    suite_add_tcase(s, t);
    r = srunner_create(s);
    srunner_run_all(r, CK_NORMAL);
    failed = srunner_ntests_failed(r);
    srunner_free(r);
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
