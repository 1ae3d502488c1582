/* SPDX-License-Identifier: Apache-2.0 */
/* BOP's visible surface discrepancy against NumPy, and the symmetries that its other errors try. */
#include "eval/symmetry.h"
#include "eval/vsd.h"
#include "libtensor/geometry/mat3.h"
#include "tests/eval/lcg.h"
#include "tests/eval/vsd_vectors.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { H = 12, W = 16, STEPS = 10 };

static float e[H * W], g[H * W], measured[H * W];

static void draw(uint32_t *state, double *out)
{
    for (int i = 0; i < H * W; i++)
        out[i] = lcg(state);
}

static void mask(uint32_t *state, const double *image, float *out)
{
    double hole[H * W];

    draw(state, hole);
    for (int i = 0; i < H * W; i++)
        out[i] = hole[i] > 0.5 ? 0 : (float)image[i];
}

/* As scripts/vectors/metrics.py makes them. */
static eval_vsd_view make_images(int kind)
{
    static const double apart[] = { 0.001, 0.01, 0.03, 0.08 };
    uint32_t state = 300 + (uint32_t)kind;
    double a[H * W], b[H * W], m[H * W];

    draw(&state, a);
    draw(&state, b);
    draw(&state, m);
    for (int i = 0; i < H * W; i++) {
        a[i] = 0.7 + 0.05 * a[i];
        b[i] = a[i] + apart[kind] * b[i];
        m[i] = fmin(a[i], b[i]) + 0.03 * m[i];
    }
    mask(&state, a, g);
    mask(&state, b, e);
    mask(&state, m, measured);
    return (eval_vsd_view){ W, H, { 20, 21, 7.5, 5 }, measured, 0.015, 0.2 };
}

START_TEST(like_numpy)
{
    const eval_vsd_view view = make_images(_i);
    double tau[STEPS], errors[STEPS];

    for (int k = 0; k < STEPS; k++)
        tau[k] = (k + 1) * 0.05;
    eval_vsd(&view, e, g, STEPS, tau, errors);
    for (int k = 0; k < STEPS; k++)
        ck_assert_double_eq_tol(errors[k], vsd_wanted[_i][k], 1e-9);
}
END_TEST

START_TEST(same_and_nothing)
{
    eval_vsd_view view = make_images(0);
    double tau = 0.05, error;

    eval_vsd(&view, g, g, 1, &tau, &error);
    ck_assert_double_eq(error, 0);
    memset(e, 0, sizeof(e));
    eval_vsd(&view, e, g, 1, &tau, &error);
    ck_assert_double_eq(error, 1);
    for (int i = 0; i < H * W; i++)
        measured[i] = 0.1f;                         /* something in front hides both */
    eval_vsd(&view, g, g, 1, &tau, &error);
    ck_assert_double_eq(error, 1);
}
END_TEST

static void check_turn(const ycb_object *o, const eval_pose *s)
{
    double I[9], t[9], centre[3];

    lt_mat3_transpose(s->R, t);
    lt_mat3_mul(s->R, t, I);
    for (int i = 0; i < 9; i++)
        ck_assert_double_eq_tol(I[i], i % 4 == 0, 1e-12);
    lt_rigid_apply(s->R, s->t, o->centre, centre);
    for (int k = 0; k < 3; k++)
        ck_assert_double_eq_tol(centre[k], o->centre[k], 1e-12);
}

/* By YCB id; those of BOP's list without a turn of their own have a handle. */
START_TEST(symmetries)
{
    static const int wanted[YCB_COUNT + 1] = {
        [1] = 314, [13] = 314, [14] = 0, [16] = 7, [18] = 314, [19] = 1, [20] = 1, [21] = 1,
    };
    static eval_pose s[EVAL_TURNS];

    for (int id = 1; id <= YCB_COUNT; id++) {
        const ycb_object *o = ycb_find(id);
        const int n = eval_symmetries(o, s);

        ck_assert_int_eq(n, wanted[id]);
        for (int i = 0; i < n; i++)
            check_turn(o, &s[i]);
    }
    ck_assert_int_eq(eval_symmetries(ycb_find(21), s), 1);          /* the brick about its long side, y */
    ck_assert_double_gt(s[0].R[4], 0.99);
    ck_assert_double_lt(s[0].R[0], -0.99);
}
END_TEST

int main(void)
{
    TCase *t = tcase_create("bop");
    Suite *s = suite_create("bop");
    SRunner *r;
    int failed;

    tcase_add_loop_test(t, like_numpy, 0, 4);
    tcase_add_test(t, same_and_nothing);
    tcase_add_test(t, symmetries);
    suite_add_tcase(s, t);
    r = srunner_create(s);
    srunner_run_all(r, CK_NORMAL);
    failed = srunner_ntests_failed(r);
    srunner_free(r);
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
