/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters that are stepped by rows: which rows have a gradient, and what moves when rows do. */
#include "libtensor/graph/plan.h"
#include "libtensor/graph/rows.h"
#include "libtensor/ops/ops.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { ROWS = 8, WIDTH = 3 };

static lt_params *set;
static lt_param *p;

static void start(void)
{
    set = lt_params_new();
    p = lt_params_add_rows(set, "points", "place", LT_SHAPE(ROWS, WIDTH));
    check_ok(lt_params_status(set));
    for (int i = 0; i < ROWS * WIDTH; i++)
        p->data[i] = (lt_real)i;
    check_ok(lt_kernels_init());
}

static void stop(void)
{
    lt_params_free(set);
}

/* ---- which rows a step has ---------------------------------------------------------------------------- */

static void check_touched(const char *want)
{
    char got[ROWS + 1] = "";
    const lt_row_range *r;
    int n, rows = 0;

    for (int i = 0; i < ROWS; i++)
        got[i] = lt_param_is_touched(p, i) ? 'x' : '.';
    ck_assert_str_eq(got, want);
    r = lt_param_touched(p, &n);
    for (int i = 0; i < n; i++) {
        ck_assert(r[i].n > 0 && (i == 0 || r[i].first > r[i - 1].first + r[i - 1].n));
        rows += (int)r[i].n;
    }
    for (int i = 0; i < ROWS; i++)
        rows -= want[i] == 'x';
    ck_assert_int_eq(rows, 0);
}

START_TEST(ranges_join)
{
    check_ok(lt_param_touch(p, 1, 2));
    check_touched(".xx.....");
    check_ok(lt_param_touch(p, 6, 2));
    check_touched(".xx...xx");
    check_ok(lt_param_touch(p, 4, 1));
    check_touched(".xx.x.xx");
    check_ok(lt_param_touch(p, 3, 0));
    check_touched(".xx.x.xx");
    check_ok(lt_param_touch(p, 2, 2));
    check_touched(".xxxx.xx");
    check_ok(lt_param_touch(p, 0, 8));
    check_touched("xxxxxxxx");
    lt_params_untouch(set);
    check_touched("........");
}
END_TEST

/* Every pair of ranges after a third: what is touched, and that only what was not is cleared */
START_TEST(touching_clears_what_is_new)
{
    ck_assert(lt_param_need_grad(p));
    for (int a = 0; a < ROWS; a++)
        for (int n = 1; a + n <= ROWS; n++) {
            char want[ROWS + 1] = ".x..xx..";

            lt_params_untouch(set);
            check_ok(lt_param_touch(p, 4, 2));
            check_ok(lt_param_touch(p, 1, 1));
            for (int i = 0; i < ROWS * WIDTH; i++)
                p->grad[i] = 7;
            check_ok(lt_param_touch(p, a, n));
            for (int i = 0; i < ROWS; i++) {
                const bool is_new = want[i] == '.' && i >= a && i < a + n;

                ck_assert(p->grad[i * WIDTH] == (is_new ? 0 : 7) && p->grad[i * WIDTH + 2] == (is_new ? 0 : 7));
                want[i] = is_new ? 'x' : want[i];
            }
            check_touched(want);
        }
}
END_TEST

START_TEST(zeroing_is_of_touched_rows)
{
    ck_assert(lt_param_need_grad(p));
    check_ok(lt_param_touch(p, 2, 3));
    for (int i = 0; i < ROWS * WIDTH; i++)
        p->grad[i] = 7;
    lt_params_zero_grad(set);
    for (int i = 0; i < ROWS * WIDTH; i++)
        ck_assert(p->grad[i] == (i / WIDTH >= 2 && i / WIDTH < 5 ? 0 : 7));
}
END_TEST

static void expect(lt_status st, lt_status want, const char *message)
{
    ck_assert_int_eq(st, want);
    ck_assert_str_eq(lt_last_error(), message);
}

START_TEST(what_cannot_be)
{
    lt_param *plain = lt_params_add(set, "", "plain", LT_WEIGHT, LT_SHAPE(4));
    const lt_row_source none[] = { { 8, false }, { 0, false } };
    lt_real before[ROWS * WIDTH];

    memcpy(before, p->data, sizeof(before));
    expect(lt_param_touch(p, 7, 2), LT_EINVAL, "parameter \"points.place\" has 8 rows, not 2 from 7 on");
    expect(lt_param_touch(p, -1, 2), LT_EINVAL, "parameter \"points.place\" has 8 rows, not 2 from -1 on");
    expect(lt_param_touch(p, INT64_MAX, INT64_MAX), LT_EINVAL,
           "parameter \"points.place\" has 8 rows, not 9223372036854775807 from 9223372036854775807 on");
    expect(lt_param_touch(plain, 0, 1), LT_EINVAL,
           "parameter \"plain\" is not stepped by rows; add it with lt_params_add_rows");
    expect(lt_param_resize(plain, 9), LT_EINVAL,
           "parameter \"plain\" is not stepped by rows; add it with lt_params_add_rows");
    expect(lt_param_resize(p, 0), LT_EINVAL, "parameter \"points.place\" cannot become (0, 3)");
    expect(lt_param_resize(p, INT64_MAX), LT_EINVAL,
           "parameter \"points.place\" cannot become (9223372036854775807, 3)");
    expect(lt_param_gather(p, 2, none), LT_EINVAL,
           "parameter \"points.place\": row 0 is to be made from row 8, of 8");
    ck_assert_mem_eq(before, p->data, sizeof(before));
    lt_params_add_rows(set, "", "number", (lt_shape){ 0 });
    expect(lt_params_status(set), LT_ESHAPE, "parameter \"number\" is a number, want rows");
}
END_TEST

/* ---- moving rows -------------------------------------------------------------------------------------- */

static void check_row(const lt_real *data, int row, double want)
{
    for (int k = 0; k < WIDTH; k++)
        ck_assert_double_eq(data[row * WIDTH + k], want < 0 ? 0 : want * WIDTH + k);
}

START_TEST(rows_move_together)
{
    static const lt_row_source from[] = {
        { 7, false }, { 2, false }, { 2, true }, { -1, false }, { 3, false }, { 0, true }, { 5, false }, { 6, false },
        { 1, false },
    };
    const int rows = ROWS + _i;                         /* in place, and to another */
    lt_row_array keeps = { .width = WIDTH, .keeps = true }, restarts = { .width = WIDTH };
    const lt_real *data, *grad;

    ck_assert(lt_param_need_grad(p));
    check_ok(lt_param_attach(p, &keeps));
    check_ok(lt_param_attach(p, &restarts));
    check_ok(lt_param_touch(p, 2, 2));
    memcpy(p->grad, p->data, ROWS * WIDTH * sizeof(lt_real));
    memcpy(keeps.data, p->data, ROWS * WIDTH * sizeof(lt_real));
    memcpy(restarts.data, p->data, ROWS * WIDTH * sizeof(lt_real));
    data = p->data;
    grad = p->grad;
    check_ok(lt_param_gather(p, rows, from));
    ck_assert_int_eq(p->shape.dim[0], rows);
    ck_assert((p->data == data) == (_i == 0) && (p->grad == grad) == (_i == 0));
    for (int i = 0; i < rows; i++) {
        const double was = (double)from[i].from;

        check_row(p->data, i, was);
        check_row(keeps.data, i, was);
        check_row(p->grad, i, from[i].fresh ? -1 : was);
        check_row(restarts.data, i, from[i].fresh ? -1 : was);
    }
    check_touched(".xx.x...");
    lt_param_detach(p, &keeps);
    lt_param_detach(p, &restarts);
    ck_assert(!keeps.data && !restarts.data);
}
END_TEST

START_TEST(resizing_keeps_the_order)
{
    check_ok(lt_param_touch(p, 6, 2));
    check_ok(lt_param_resize(p, lt_rows_capacity(ROWS)));
    ck_assert_int_eq(p->shape.dim[0], LT_ROWS_STEP);
    for (int i = 0; i < ROWS + 1; i++)
        check_row(p->data, i, i < ROWS ? i : -1);
    check_touched("......xx");
    check_ok(lt_param_resize(p, 7));
    for (int i = 0; i < 7; i++)
        check_row(p->data, i, i);
    check_touched("......x.");
    ck_assert_int_eq(lt_rows_capacity(0), 0);
    ck_assert_int_eq(lt_rows_capacity(1024), 1024);
    ck_assert_int_eq(lt_rows_capacity(1025), 2048);
}
END_TEST

/* A file may say how many rows there are before any memory is taken. */
START_TEST(resizing_before_there_are_values)
{
    lt_param *later;

    lt_params_defer(set);
    later = lt_params_add_rows(set, "", "later", LT_SHAPE(2, WIDTH));
    check_ok(lt_params_status(set));
    ck_assert(!later->data);
    check_ok(lt_param_resize(later, 4));
    ck_assert(!later->data && later->shape.dim[0] == 4);
    check_ok(lt_params_allocate(set));
    check_row(later->data, 3, -1);
    check_ok(lt_param_resize(later, 5));
    check_row(later->data, 4, -1);
}
END_TEST

/* Whichever block of memory is refused, all stays as it was. */
START_TEST(resizing_without_memory)
{
    lt_row_array extra = { .width = 1 };
    int refused = 0;

    ck_assert(lt_param_need_grad(p));
    check_ok(lt_param_attach(p, &extra));
    for (long n = 1;; n++) {
        lt_status st;

        lt_alloc_fail_at(n);
        st = lt_param_resize(p, 100);
        lt_alloc_fail_at(0);
        if (!st)
            break;
        ck_assert_int_eq(st, LT_ENOMEM);
        ck_assert_int_eq(p->shape.dim[0], ROWS);
        check_row(p->data, 7, 7);
        refused++;
    }
    ck_assert_int_eq(refused, 3);
    lt_param_detach(p, &extra);
}
END_TEST

/* ---- in a plan ---------------------------------------------------------------------------------------- */

/* loss = sum over two ranges of w * row, whose places are inputs */
typedef struct {
    lt_graph *g;
    lt_tensor *first[2], *w[2], *out[2], *loss;
    lt_plan *plan;
} reader;

static reader read_rows(const lt_compile_opts *opts)
{
    reader r = { .g = lt_graph_new() };
    lt_compile_opts o = *opts;

    for (int i = 0; i < 2; i++) {
        r.first[i] = lt_input(r.g, "first", LT_I32, 0, NULL);
        r.w[i] = lt_input(r.g, "w", LT_F32, 2, (int64_t[]){ 2, WIDTH });
        r.out[i] = lt_output(lt_rows(lt_use(r.g, p), r.first[i], 2), "rows");
    }
    r.loss = lt_add(lt_sum(lt_mul(r.out[0], r.w[0])), lt_sum(lt_mul(r.out[1], r.w[1])));
    o.loss = r.loss;
    r.plan = lt_compile(r.g, &o);
    ck_assert_msg(r.plan != NULL, "%s", lt_last_error());
    return r;
}

static void reader_free(reader *r)
{
    lt_plan_free(r->plan);
    lt_graph_free(r->g);
}

static void fill(lt_plan *part, const reader *r, int a, int b)
{
    const int first[] = { a, b };

    for (int i = 0; i < 2; i++) {
        *(int32_t *)lt_plan_data(part, r->first[i]) = first[i];
        for (int k = 0; k < 2 * WIDTH; k++)
            ((lt_real *)lt_plan_data(part, r->w[i]))[k] = (lt_real)(1 + i);
    }
}

START_TEST(places_are_data)
{
    reader r = read_rows(&(lt_compile_opts){ 0 });

    for (int at = 0; at < ROWS - 1; at++) {
        fill(r.plan, &r, at, ROWS - 1 - at);
        check_ok(lt_run(r.plan));
        for (int i = 0; i < 2; i++) {
            check_row(lt_plan_data(r.plan, r.out[0]), i, at + i);
            check_row(lt_plan_data(r.plan, r.out[1]), i, at == 0 && i == 1 ? -1 : ROWS - 1 - at + i);
        }
    }
    reader_free(&r);
}
END_TEST

/* Gradients of touched rows alone are written, whether replaced or added, and by parts too. */
START_TEST(gradients_are_of_touched_rows)
{
    static const lt_compile_opts how[] = {
        { .train = true }, { .train = true, .replace_grads = true },
        { .train = true, .replace_grads = true, .parts = 2 },
    };
    const int parts = how[_i].parts ? how[_i].parts : 1;
    const double times = _i == 2 ? 2 : 1;
    reader r = read_rows(&how[_i]);

    check_ok(lt_param_touch(p, 1, 2));
    check_ok(lt_param_touch(p, 5, 1));
    for (int i = 0; i < ROWS * WIDTH; i++)
        if (!lt_param_is_touched(p, i / WIDTH))
            p->grad[i] = NAN;
    for (int run = 0; run < 2; run++) {
        for (int k = 0; k < parts; k++)
            fill(lt_plan_part(r.plan, k), &r, 1, 4 - 3 * k);
        check_ok(lt_run(r.plan));
        if (_i == 0 && run == 0)
            lt_params_zero_grad(set);
    }
    for (int i = 0; i < ROWS * WIDTH; i++) {
        const int row = i / WIDTH;

        if (lt_param_is_touched(p, row))
            ck_assert_double_eq(p->grad[i], row == 5 ? 2 : times * 1 + (_i == 2 ? 2 : 0));
        else
            ck_assert(isnan(p->grad[i]));
    }
    reader_free(&r);
}
END_TEST

START_TEST(nothing_else_reads_them)
{
    lt_graph *g = lt_graph_new();
    lt_tensor *x = lt_use(g, p);

    if (_i)
        x = lt_reshape(x, LT_SHAPE(ROWS * WIDTH));
    ck_assert(!lt_compile(g, &(lt_compile_opts){ .loss = lt_sum(x), .train = true }));
    ck_assert_msg(strstr(lt_last_error(), "reads all of \"points.place\", which is stepped by rows; read those of a "
                         "step with lt_rows"), "%s", lt_last_error());
    p->frozen = true;                                   /* then there is no gradient to write */
    x = lt_input(g, "x", LT_F32, 2, (int64_t[]){ ROWS, WIDTH });
    lt_want_grad(x);
    x = lt_sum(lt_mul(x, lt_use(g, p)));
    lt_plan_free(lt_compile(g, &(lt_compile_opts){ .loss = x, .train = true }));
    lt_graph_free(g);
}
END_TEST

START_TEST(bad_gradients_of_other_rows_are_not_found)
{
    reader r = read_rows(&(lt_compile_opts){ .train = true, .replace_grads = true });
    char where[64];

    check_ok(lt_param_touch(p, 0, 2));
    p->grad[7 * WIDTH] = NAN;
    fill(r.plan, &r, 0, 0);
    lt_plan_find_nonfinite(r.plan, where, sizeof(where));
    ck_assert_str_eq(where, "");
    check_ok(lt_param_touch(p, 0, ROWS));
    *(lt_real *)lt_plan_data(r.plan, r.w[1]) = INFINITY;
    lt_plan_find_nonfinite(r.plan, where, sizeof(where));
    ck_assert_msg(*where, "an infinite gradient is not found");
    reader_free(&r);
}
END_TEST

/* A plan is of the size that it was compiled for. */
START_TEST(a_resized_parameter_makes_plans_stale)
{
    static const char message[] = "\"points.place\" has been resized since the plan was compiled; record the graph and "
                                  "compile it again";
    reader r = read_rows(&(lt_compile_opts){ .train = _i });
    const lt_row_source from[ROWS] = { { 3, false }, { 4, false }, { 5, false } };
    char where[16];

    fill(r.plan, &r, 0, 1);
    check_ok(lt_param_gather(p, ROWS, from));           /* in place */
    check_ok(lt_run(r.plan));
    check_row(lt_plan_data(r.plan, r.out[0]), 1, 4);
    check_ok(lt_param_resize(p, ROWS + 1));
    expect(lt_run(r.plan), LT_EINVAL, message);
    check_ok(lt_param_resize(p, ROWS));                 /* another place of the same size */
    expect(lt_run(r.plan), LT_EINVAL, message);
    lt_plan_refresh(r.plan);
    lt_plan_find_nonfinite(r.plan, where, sizeof(where));
    check_ok(lt_param_resize(p, ROWS + 2));
    ck_assert(!lt_compile(r.g, NULL));
    ck_assert_str_eq(lt_last_error(), "the graph has \"points.place\" as (8, 3), and now it is (10, 3); record the "
                     "graph again");
    reader_free(&r);
    r = read_rows(&(lt_compile_opts){ .train = _i });
    fill(r.plan, &r, 0, 1);
    check_ok(lt_run(r.plan));
    reader_free(&r);
}
END_TEST

/* Plans that do not have the parameter go on. */
START_TEST(other_plans_go_on)
{
    lt_param *other = lt_params_add(set, "", "other", LT_WEIGHT, LT_SHAPE(2));
    lt_graph *g = lt_graph_new();
    lt_tensor *y = lt_output(lt_sum(lt_use(g, other)), "y");
    lt_plan *plan = lt_compile(g, NULL);

    check_ok(lt_param_resize(p, 20));
    other->data[0] = 3;
    lt_params_changed(set);
    check_ok(lt_run(plan));
    ck_assert_double_eq(*(lt_real *)lt_plan_data(plan, y), 3);
    lt_plan_free(plan);
    lt_graph_free(g);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_test(tc, ranges_join);
    tcase_add_test(tc, touching_clears_what_is_new);
    tcase_add_test(tc, zeroing_is_of_touched_rows);
    tcase_add_test(tc, what_cannot_be);
    tcase_add_loop_test(tc, rows_move_together, 0, 2);
    tcase_add_test(tc, resizing_keeps_the_order);
    tcase_add_test(tc, resizing_before_there_are_values);
    tcase_add_test(tc, resizing_without_memory);
    tcase_add_test(tc, places_are_data);
    tcase_add_loop_test(tc, gradients_are_of_touched_rows, 0, 3);
    tcase_add_loop_test(tc, nothing_else_reads_them, 0, 2);
    tcase_add_test(tc, bad_gradients_of_other_rows_are_not_found);
    tcase_add_loop_test(tc, a_resized_parameter_makes_plans_stale, 0, 2);
    tcase_add_test(tc, other_plans_go_on);
}

int main(void)
{
    return run_suite("rows", add_tests);
}
