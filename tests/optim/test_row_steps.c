/* SPDX-License-Identifier: Apache-2.0 */
/* Steps of some rows of a parameter: each with its own clock, as PyTorch's Adam on sets of its own, also across growth;
 * the same bits wherever rows are, on any number of threads, and after a resume. */
#include "libtensor/base/parallel.h"
#include "libtensor/graph/plan.h"
#include "libtensor/graph/rows.h"
#include "libtensor/ops/ops.h"
#include "libtensor/optim/optim.h"
#include "tests/optim/optim_vectors.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>

enum { N = 5, ROWS = 5, STEPS = 6 };

static const lt_optim_group points[] = {
    { .name = "points", .kind = LT_ADAM, .eps = 1e-15, .schedule = { .lr = 0.05 } },
};

static lt_params *set;
static lt_param *p;

static void start(void)
{
    set = lt_params_new();
    p = lt_params_add_rows(set, "points", "place", LT_SHAPE(ROWS, N));
    ck_assert(lt_param_need_grad(p));
    check_ok(lt_kernels_init());
    for (int i = 0; i < ROWS * N; i++)
        p->data[i] = (lt_real)(i % N - 2) / 4 + (lt_real)(i / N) / 8;
}

static void stop(void)
{
    lt_params_free(set);
}

/* ---- against PyTorch ---------------------------------------------------------------------------------- */

/* The same formula as in scripts/vectors/optim.py, for rows of a step; others have gradients that nobody may read. */
static void set_gradients(int step)
{
    for (int i = 0; i < (int)lt_param_numel(p); i++) {
        const int r = i / N, k = i % N + 1;

        p->grad[i] = lt_param_is_touched(p, r) ? (lt_real)(k * (p->data[i] - 0.25) + sin((double)k * step + r) / 8)
                                               : (lt_real)NAN;
    }
}

/* Sets of rows 0, 1 to 2, 3 take part always, in odd steps, in every third. */
static void touch(int step)
{
    lt_params_untouch(set);
    check_ok(lt_param_touch(p, 0, 1));
    if (step % 2 == 1)
        check_ok(lt_param_touch(p, 1, 2));
    if (step % 3 == 0)
        check_ok(lt_param_touch(p, 3, 1));
}

static void take_step(lt_optim *o, int step)
{
    touch(step);
    set_gradients(step);
    ck_assert(isfinite(lt_optim_groups_norm(o, 1)));
    lt_optim_step_groups(o, &(lt_optim_now){ .groups = 1 });
}

static void check_rows(const double *want, int rows)
{
    for (int i = 0; i < rows * N; i++)
        ck_assert_msg(fabs((double)p->data[i] - want[i]) < 5e-7, "row %d, %d is %.9g, want %.9g", i / N, i % N,
                      (double)p->data[i], want[i]);
}

START_TEST(each_row_has_its_clock)
{
    lt_optim *o = lt_optim_new_groups(set, points, 1, NULL);
    const lt_real *clock;

    for (int step = 1; step <= 2 * STEPS; step++)
        take_step(o, step);
    check_rows(want_rows, ROWS);
    ck_assert_str_eq(lt_optim_state_at(o, 2).name, "optim.t.points.place");
    ck_assert_int_eq(lt_optim_state_at(o, 2).shape.rank, 1);
    clock = lt_optim_state_at(o, 2).data;
    ck_assert(clock[0] == 12 && clock[1] == 6 && clock[2] == 6 && clock[3] == 4 && clock[4] == 0);
    lt_optim_free(o);
}
END_TEST

static void densify(void)
{
    static const lt_row_source from[] = {
        { 0, false }, { 2, false }, { 1, true }, { 3, false }, { 4, false }, { -1, false }, { -1, false },
    };

    check_ok(lt_param_gather(p, ROWS + 2, from));
}

START_TEST(rows_that_grew)
{
    lt_optim *o = lt_optim_new_groups(set, points, 1, NULL);

    for (int step = 1; step <= 2 * STEPS; step++) {
        take_step(o, step);
        if (step == STEPS)
            densify();
    }
    check_rows(want_rows_grown, ROWS);
    lt_optim_free(o);
}
END_TEST

/* lt_optim_new's too */
START_TEST(one_recipe_steps_rows)
{
    lt_optim *o = lt_optim_new(set, &(lt_optim_opts){ .kind = LT_ADAM, .eps = 1e-15 });

    for (int step = 1; step <= 2 * STEPS; step++) {
        touch(step);
        set_gradients(step);
        lt_optim_step(o, 0.05, lt_optim_grad_norm(o));
    }
    check_rows(want_rows, ROWS);
    lt_optim_free(o);
}
END_TEST

START_TEST(the_norm_is_of_touched_rows)
{
    lt_optim *o = lt_optim_new_groups(set, points, 1, NULL);

    touch(3);
    set_gradients(3);
    for (int i = 0; i < 4 * N; i++)
        p->grad[i] = 2;
    ck_assert_double_eq_tol(lt_optim_grad_norm(o), sqrt(4.0 * 4 * N), 1e-12);
    lt_params_untouch(set);
    ck_assert_double_eq(lt_optim_grad_norm(o), 0);
    lt_optim_step_groups(o, &(lt_optim_now){ .groups = 1 });            /* nothing moves */
    ck_assert_double_eq(lt_optim_state_at(o, 2).data[0], 0);
    lt_optim_free(o);
}
END_TEST

START_TEST(moments_are_forgotten)
{
    lt_optim *o = lt_optim_new_groups(set, points, 1, NULL);
    const lt_real *m = lt_optim_state_at(o, 0).data, *v = lt_optim_state_at(o, 1).data;

    take_step(o, 1);
    lt_optim_forget(o, p, 1, 100);
    for (int i = 0; i < 3 * N; i++)
        ck_assert((m[i] != 0) == (i < N) && (v[i] != 0) == (i < N));
    ck_assert_double_eq(lt_optim_state_at(o, 2).data[1], 1);
    lt_optim_forget(o, p, -5, 2);
    lt_optim_forget(o, p, 9, 2);
    ck_assert(m[0] != 0);
    lt_optim_free(o);
}
END_TEST

/* ---- the same bits ------------------------------------------------------------------------------------ */

/* A run on many rows: four sets that a plan reads, two of them in each step, the places of sets being data. */
enum { SETS = 4, CAPACITY = 1024, LONG = 20, GROW_AT = 8, SAVE_AT = 13 };

typedef struct {
    lt_params *set;
    lt_param *place, *size, *net;
    lt_optim *o;
    lt_graph *g;
    lt_tensor *first[2], *aim[2], *loss;
    lt_plan *plan;
    int64_t at[SETS];               /* the first row of each */
} cloud;

static const char *const names_place[] = { "cloud.place", NULL }, *const names_size[] = { "cloud.size", NULL };
static const lt_optim_group cloud_groups[] = {
    { .name = "place", .prefix = names_place, .kind = LT_ADAM, .eps = 1e-15, .by_step = true,
      .schedule = { .kind = LT_LOG_LINEAR_LR, .lr = 0.1, .min_lr = 0.01, .epochs = LONG } },
    { .name = "size", .prefix = names_size, .kind = LT_ADAMW, .weight_decay = 0.01, .schedule = { .lr = 0.01 } },
    { .name = "net", .kind = LT_ADAM, .schedule = { .lr = 0.001 }, .clip_norm = 0.1 },
};

static void compile(cloud *c)
{
    lt_plan_free(c->plan);
    lt_graph_free(c->g);
    c->g = lt_graph_new();
    c->loss = NULL;
    for (int i = 0; i < 2; i++) {
        lt_tensor *size, *y;

        c->first[i] = lt_input(c->g, "first", LT_I32, 0, NULL);
        c->aim[i] = lt_input(c->g, "aim", LT_F32, 2, (int64_t[]){ CAPACITY, 3 });
        size = lt_rows(lt_use(c->g, c->size), c->first[i], CAPACITY);
        y = lt_mul(lt_rows(lt_use(c->g, c->place), c->first[i], CAPACITY), size);
        y = lt_mse_loss(lt_mul(y, lt_use(c->g, c->net)), c->aim[i], NULL);
        c->loss = c->loss ? lt_add(c->loss, y) : y;
    }
    c->plan = lt_compile(c->g, &(lt_compile_opts){ .loss = c->loss, .train = true, .replace_grads = true });
    ck_assert_msg(c->plan != NULL, "%s", lt_last_error());
}

static cloud cloud_new(int64_t rows, const int64_t *at)
{
    const lt_optim_average average = { .decay = 0.9 };
    cloud c = { .set = lt_params_new() };

    c.place = lt_params_add_rows(c.set, "cloud", "place", LT_SHAPE(rows, 3));
    c.size = lt_params_add_rows(c.set, "cloud", "size", LT_SHAPE(rows, 1));
    c.net = lt_params_add(c.set, "", "net", LT_WEIGHT, LT_SHAPE(3));
    check_ok(lt_params_status(c.set));
    memcpy(c.at, at, sizeof(c.at));
    for (int s = 0; s < SETS; s++)
        for (int i = 0; i < CAPACITY; i++) {
            for (int k = 0; k < 3; k++)
                c.place->data[3 * (at[s] + i) + k] = (lt_real)sin(s + 3 * i + k);
            c.size->data[at[s] + i] = 1;
        }
    for (int k = 0; k < 3; k++)
        c.net->data[k] = 1;
    compile(&c);
    c.o = lt_optim_new_groups(c.set, cloud_groups, 3, &average);
    ck_assert_msg(c.o != NULL, "%s", lt_last_error());
    return c;
}

static void cloud_free(cloud *c)
{
    lt_optim_free(c->o);
    lt_plan_free(c->plan);
    lt_graph_free(c->g);
    lt_params_free(c->set);
}

static void cloud_step(cloud *c, int step)
{
    lt_params_untouch(c->set);
    for (int i = 0; i < 2; i++) {
        const int s = (step + i * (1 + step % 3)) % SETS;
        lt_real *aim = lt_plan_data(c->plan, c->aim[i]);

        *(int32_t *)lt_plan_data(c->plan, c->first[i]) = (int32_t)c->at[s];
        for (int k = 0; k < 3 * CAPACITY; k++)
            aim[k] = (lt_real)cos(k + s);
        check_ok(lt_param_touch(c->place, c->at[s], CAPACITY));
        check_ok(lt_param_touch(c->size, c->at[s], CAPACITY));
    }
    check_ok(lt_run(c->plan));
    ck_assert(isfinite(lt_optim_groups_norm(c->o, 7)));
    lt_optim_step_groups(c->o, &(lt_optim_now){ .groups = step % 5 ? 7 : 3, .step = step });
}

/* Set s goes behind all others, where its odd rows are new ones made from the even rows before them. */
static void cloud_grow(cloud *c, int s)
{
    const int64_t rows = c->place->shape.dim[0], more = rows + CAPACITY;
    lt_row_source *from = calloc((size_t)more, sizeof(*from));

    for (int64_t i = 0; i < more; i++)
        from[i] = (lt_row_source){ i < rows ? i : c->at[s] + (i - rows) / 2 * 2, i >= rows && i % 2 };
    check_ok(lt_param_gather(c->place, more, from));
    check_ok(lt_param_gather(c->size, more, from));
    free(from);
    c->at[s] = rows;
    compile(c);
}

static void check_same_set(const lt_real *a, int64_t at_a, const lt_real *b, int64_t at_b, int64_t width)
{
    ck_assert_mem_eq(a + at_a * width, b + at_b * width, (size_t)(CAPACITY * width) * sizeof(lt_real));
}

/* Rows of all sets, whatever the optimiser has of them too, and the network are the same in both. */
static void check_same(const cloud *a, const cloud *b)
{
    ck_assert_int_eq(lt_optim_state_count(a->o), lt_optim_state_count(b->o));
    for (int s = 0; s < SETS; s++) {
        check_same_set(a->place->data, a->at[s], b->place->data, b->at[s], 3);
        check_same_set(a->size->data, a->at[s], b->size->data, b->at[s], 1);
        for (int i = 0; i < lt_optim_state_count(a->o); i++) {
            const lt_optim_state x = lt_optim_state_at(a->o, i), y = lt_optim_state_at(b->o, i);

            if (x.shape.dim[0] == a->place->shape.dim[0])
                check_same_set(x.data, a->at[s], y.data, b->at[s], lt_shape_numel(&x.shape) / x.shape.dim[0]);
            else
                ck_assert_mem_eq(x.data, y.data, (size_t)lt_shape_numel(&x.shape) * sizeof(lt_real));
        }
    }
    ck_assert_mem_eq(a->net->data, b->net->data, 3 * sizeof(lt_real));
}

static const int64_t in_order[] = { 0, CAPACITY, 2 * CAPACITY, 3 * CAPACITY };

static cloud whole_run(int64_t rows, const int64_t *at, int threads)
{
    cloud c = cloud_new(rows, at);

    lt_set_threads(threads);
    for (int step = 0; step < LONG; step++) {
        if (step == GROW_AT)
            cloud_grow(&c, 1);
        cloud_step(&c, step);
    }
    lt_set_threads(0);
    return c;
}

START_TEST(threads_give_the_same_bits)
{
    cloud a = whole_run(SETS * CAPACITY, in_order, 1), b = whole_run(SETS * CAPACITY, in_order, 2 + _i);

    check_same(&a, &b);
    cloud_free(&a);
    cloud_free(&b);
}
END_TEST

/* More room, and sets in another order, change nothing. */
START_TEST(places_give_the_same_bits)
{
    static const int64_t apart[] = { 5 * CAPACITY, 1, 2 * CAPACITY + 17, 7 * CAPACITY - 3 };
    cloud a = whole_run(SETS * CAPACITY, in_order, 2), b = whole_run(8 * CAPACITY, apart, 2);

    check_same(&a, &b);
    cloud_free(&a);
    cloud_free(&b);
}
END_TEST

/* Saved behind a growth: the new run has the old size, is resized, and then what was saved is put back. */
START_TEST(resumes_across_growth)
{
    cloud a = cloud_new(SETS * CAPACITY, in_order), b = cloud_new(SETS * CAPACITY, in_order);

    for (int step = 0; step < LONG; step++) {
        if (step == GROW_AT)
            cloud_grow(&a, 1);
        if (step == SAVE_AT) {
            const int64_t rows = a.place->shape.dim[0];

            check_ok(lt_param_resize(b.place, rows));
            check_ok(lt_param_resize(b.size, rows));
            memcpy(b.at, a.at, sizeof(b.at));
            memcpy(b.place->data, a.place->data, (size_t)(3 * rows) * sizeof(lt_real));
            memcpy(b.size->data, a.size->data, (size_t)rows * sizeof(lt_real));
            memcpy(b.net->data, a.net->data, 3 * sizeof(lt_real));
            for (int i = 0; i < lt_optim_state_count(a.o); i++) {
                const lt_optim_state from = lt_optim_state_at(a.o, i), to = lt_optim_state_at(b.o, i);

                ck_assert_str_eq(from.name, to.name);
                ck_assert(lt_same_shape(&from.shape, &to.shape));
                memcpy(to.data, from.data, (size_t)lt_shape_numel(&to.shape) * sizeof(lt_real));
            }
            lt_optim_set_steps(b.o, lt_optim_steps(a.o));
            compile(&b);
        }
        cloud_step(&a, step);
        if (step >= SAVE_AT)
            cloud_step(&b, step);
    }
    check_same(&a, &b);
    cloud_free(&a);
    cloud_free(&b);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 60);
    tcase_add_checked_fixture(tc, start, stop);
    tcase_add_test(tc, each_row_has_its_clock);
    tcase_add_test(tc, rows_that_grew);
    tcase_add_test(tc, one_recipe_steps_rows);
    tcase_add_test(tc, the_norm_is_of_touched_rows);
    tcase_add_test(tc, moments_are_forgotten);
    tcase_add_loop_test(tc, threads_give_the_same_bits, 0, 3);
    tcase_add_test(tc, places_give_the_same_bits);
    tcase_add_test(tc, resumes_across_growth);
}

int main(void)
{
    return run_suite("row steps", add_tests);
}
