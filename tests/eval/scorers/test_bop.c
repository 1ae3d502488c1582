/* SPDX-License-Identifier: Apache-2.0 */
/* BOP's visible surface discrepancy against NumPy, and the symmetries that its other errors try: ours, and its own. */
#include "assets/ycb/symmetry.h"
#include "eval/metrics/vsd.h"
#include "eval/scorers/models_info.h"
#include "libtensor/geometry/mat3.h"
#include "libtensor/io/atomic_file.h"
#include "tests/eval/lcg.h"
#include "tests/eval/vsd_vectors.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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

static void check_turn(const ycb_object *o, const lt_pose *s)
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
    static lt_pose s[YCB_TURNS];

    for (int id = 1; id <= YCB_COUNT; id++) {
        const ycb_object *o = ycb_find(id);
        const int n = ycb_symmetries(o, s);

        ck_assert_int_eq(n, wanted[id]);
        for (int i = 0; i < n; i++)
            check_turn(o, &s[i]);
    }
    ck_assert_int_eq(ycb_symmetries(ycb_find(21), s), 1);          /* the brick about its long side, y */
    ck_assert_double_gt(s[0].R[4], 0.99);
    ck_assert_double_lt(s[0].R[0], -0.99);
}
END_TEST

/* ---- models_info.json ---- */

static lt_status read_text(lt_arena *arena, const char *text, bop_model out[YCB_COUNT + 1])
{
    char path[] = "/tmp/test_bop_XXXXXX";
    const int fd = mkstemp(path);
    lt_status st;

    ck_assert_int_ge(fd, 0);
    close(fd);
    ck_assert_int_eq(lt_write_file(path, text, strlen(text)), LT_OK);
    st = models_info_read(arena, path, out);
    unlink(path);
    return st;
}

/* What BOP says in its own frame, millimetres: the point p + b of object id goes to q + b. */
static void check_moves(int id, const lt_pose *s, const double p_bop[3], const double q_bop[3])
{
    const double *centre = ycb_find(id)->centre;        /* -b */
    double p[3], q[3];

    for (int k = 0; k < 3; k++)
        p[k] = p_bop[k] / 1000 + centre[k];
    lt_rigid_apply(s->R, s->t, p, q);
    for (int k = 0; k < 3; k++)
        ck_assert_double_eq_tol(q[k], q_bop[k] / 1000 + centre[k], 1e-9);
}

/* The can turns about an axis beside its origin and may stand on its head; the brick turns halfway about y, with a
 * shift; the bowl has an axis of another length; the scissors have nothing. */
START_TEST(info_of_models)
{
    static const char text[] =
        "{\"1\": {\"diameter\": 172, \"symmetries_discrete\": [[1,0,0,0, 0,-1,0,4, 0,0,-1,6, 0,0,0,1]], "
        "\"symmetries_continuous\": [{\"axis\": [0,0,1], \"offset\": [1,2,0]}]},"
        "\"13\": {\"diameter\": 161.5, \"symmetries_continuous\": [{\"axis\": [0,0,-3], \"offset\": [0,0,0]}]},"
        "\"17\": {\"diameter\": 204, \"symmetries_discrete\": []},"
        "\"21\": {\"diameter\": 103, \"min_x\": -26, "
        "\"symmetries_discrete\": [[-1,0,0,2, 0,1,0,0, 0,0,-1,-8, 0,0,0,1]]},"
        "\"22\": 5}";
    const double p[3] = { 10, 20, 30 }, a = 2 * M_PI / 315;
    lt_arena *arena = lt_arena_new();
    bop_model m[YCB_COUNT + 1];

    ck_assert_int_eq(read_text(arena, text, m), LT_OK);
    ck_assert_double_eq(m[2].diameter, 0);
    ck_assert_double_eq_tol(m[13].diameter, 0.1615, 1e-12);
    ck_assert_int_eq(m[17].n_symmetries, 0);
    ck_assert_int_eq(m[21].n_symmetries, 1);
    check_moves(21, m[21].symmetry, p, (const double[]){ 2 - 10, 20, -8 - 30 });
    ck_assert_int_eq(m[13].n_symmetries, 314);
    check_moves(13, m[13].symmetry, p, (const double[]){ 10 * cos(a) + 20 * sin(a), 20 * cos(a) - 10 * sin(a), 30 });
    ck_assert_int_eq(m[1].n_symmetries, 2 * 315 - 1);
    check_moves(1, &m[1].symmetry[0], p, (const double[]){ 1 + 9 * cos(a) - 18 * sin(a), 2 + 18 * cos(a) + 9 * sin(a),
                                                           30 });
    check_moves(1, &m[1].symmetry[314], p, (const double[]){ 10, 4 - 20, 6 - 30 });     /* on its head */
    check_moves(1, &m[1].symmetry[315], p, (const double[]){ 1 + 9 * cos(a) + 18 * sin(a), 2 - 18 * cos(a) + 9 * sin(a),
                                                             6 - 30 });                 /* then turned */
    lt_arena_free(arena);
}
END_TEST

#define CAN(symmetries) "{\"1\": {\"diameter\": 1, " symmetries "}}"

static const struct { const char *text, *why; } damaged[] = {
    { "", "" }, { "{\"1\": ", "" },
    { "[1]", "expected an object with a model for each id" },
    { "{\"13\": 7}", "object 13: diameter: " },
    { "{\"13\": {\"diameter\": 0}}", "object 13: diameter: " },
    { "{\"13\": {\"diameter\": NaN}}", "object 13: diameter: " },
    { "{\"13\": {\"diameter\": 1e9}}", "object 13: diameter: " },
    { CAN("\"symmetries_discrete\": 3"), "object 1: symmetries_discrete: expected a list" },
    { CAN("\"symmetries_discrete\": [[1,0,0,0, 0,1,0,0, 0,0,1,0]]"), "expected rigid motions" },
    { CAN("\"symmetries_discrete\": [[2,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]]"), "expected rigid" },
    { CAN("\"symmetries_discrete\": [[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]]"), "expected rigid" },
    { CAN("\"symmetries_discrete\": [[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,9,1]]"), "expected rigid" },
    { CAN("\"symmetries_discrete\": [[1,0,0,\"x\", 0,1,0,0, 0,0,1,0, 0,0,0,1]]"), "expected rigid" },
    { CAN("\"symmetries_continuous\": {}"), "symmetries_continuous: expected a list" },
    { CAN("\"symmetries_continuous\": [4]"), "expected an axis and an offset" },
    { CAN("\"symmetries_continuous\": [{\"axis\": [0,0,1]}]"), "expected an axis and an offset" },
    { CAN("\"symmetries_continuous\": [{\"axis\": [0,0,0], \"offset\": [0,0,0]}]"), "expected an axis" },
};

START_TEST(damaged_info)
{
    lt_arena *arena = lt_arena_new();
    bop_model m[YCB_COUNT + 1];

    ck_assert_int_eq(read_text(arena, damaged[_i].text, m), LT_EFORMAT);
    ck_assert_msg(strstr(lt_last_error(), damaged[_i].why) != NULL, "%s", lt_last_error());
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "test_bop_"));
    ck_assert_ptr_null(strchr(lt_last_error(), '\n'));
    lt_arena_free(arena);
}
END_TEST

/* Axes and motions that multiply to more than any model has */
START_TEST(too_many_symmetries)
{
    lt_arena *arena = lt_arena_new();
    char *discrete = lt_arena_strdup(arena, ""), *text;
    bop_model m[YCB_COUNT + 1];

    for (int i = 0; i < 8; i++)
        discrete = lt_arena_printf(arena, "%s%s[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]", discrete, i ? "," : "");
    text = lt_arena_printf(arena, CAN("\"symmetries_discrete\": [%s], "
                                      "\"symmetries_continuous\": [{\"axis\": [0,0,1], \"offset\": [0,0,0]}]"),
                                      discrete);
    ck_assert_int_eq(read_text(arena, text, m), LT_EFORMAT);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "object 1: has too many symmetries"));
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_loop_test(t, like_numpy, 0, 4);
    tcase_add_test(t, same_and_nothing);
    tcase_add_test(t, symmetries);
    tcase_add_test(t, info_of_models);
    tcase_add_loop_test(t, damaged_info, 0, (int)LT_COUNT(damaged));
    tcase_add_test(t, too_many_symmetries);
}

int main(void)
{
    return run_suite("bop", add_tests);
}
