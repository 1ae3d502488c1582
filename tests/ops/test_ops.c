/* SPDX-License-Identifier: Apache-2.0 */
/* Every op in float: values and gradients against PyTorch in float64, what it says of wrong shapes, the same
 * on every instruction set, the same bits on any number of threads and whoever wants gradients. */
#include "libtensor/base/cpu.h"
#include "libtensor/base/parallel.h"
#include "libtensor/io/array/npz.h"
#include "tests/ops/onnx_way.h"
#include "tests/ops/op_run.h"
#include "tests/suite.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- all cases in one row ------------------------------------------------------------------------- */

static int n_cases(void)
{
    int n = 0;

    for (int i = 0; i < n_op_suites; i++)
        n += op_suites[i]->n_cases;
    return n;
}

static int n_bad_cases(void)
{
    int n = 0;

    for (int i = 0; i < n_op_suites; i++)
        n += op_suites[i]->n_bad;
    return n;
}

static const op_case *case_at(int at, const op_suite **s)
{
    int i = 0;

    for (; at >= op_suites[i]->n_cases; i++)
        at -= op_suites[i]->n_cases;
    *s = op_suites[i];
    return &(*s)->cases[at];
}

static const op_bad_case *bad_case_at(int at, const op_suite **s)
{
    int i = 0;

    for (; at >= op_suites[i]->n_bad; i++)
        at -= op_suites[i]->n_bad;
    *s = op_suites[i];
    return &(*s)->bad[at];
}

/* ---- values --------------------------------------------------------------------------------------- */

typedef struct {
    const op_suite *s;
    const op_case *c;
    const char *how;                /* for messages: "avx2, training" */
    lt_npz npz;
} vectors;

static const lt_array *array(const vectors *v, const char *what, int i)
{
    char name[80];

    snprintf(name, sizeof(name), "%s.%s%d", v->c->name, what, i);
    return lt_npz_find(&v->npz, name);
}

static bool same_shape(const lt_array *a, const lt_tensor *t)
{
    return lt_array_has_shape(a, t->shape.rank, t->shape.dim);
}

static void put(const vectors *v, const op_run *r, const char *what, int i, const lt_tensor *t)
{
    const lt_array *a = array(v, what, i);

    ck_assert_msg(a && same_shape(a, t), "%s %s: %s%d is not in the file, or of another shape", v->s->name,
                  v->c->name, what, i);
    lt_array_to_float(a, op_run_data(r, t), lt_array_count(a));
}

static bool near_all(const lt_array *want, const lt_real *got, double tol, char *why, size_t bytes)
{
    const size_t n = lt_array_count(want);
    double most = 1e-30;

    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(lt_array_get(want, i)));
    for (size_t i = 0; i < n; i++) {
        const double w = lt_array_get(want, i);

        if (fabs((double)got[i] - w) <= tol * most)
            continue;
        snprintf(why, bytes, "[%zu] is %.9g, want %.9g, off by %.2g of %.3g", i, (double)got[i], w,
                 fabs((double)got[i] - w) / most, most);
        return false;
    }
    return true;
}

static void expect_near(const vectors *v, const char *what, int i, const lt_array *want, const lt_real *got,
                        double tol)
{
    char why[160];

    ck_assert_msg(near_all(want, got, tol ? tol : 1e-6, why, sizeof(why)), "%s %s (%s): %s%d%s", v->s->name,
                  v->c->name, v->how, what, i, why);
}

static void run_with_vectors(const vectors *v, op_run *r, const op_run_opts *o)
{
    ck_assert_msg(op_run_new(r, v->s, v->c, o), "%s %s: %s", v->s->name, v->c->name, lt_last_error());
    for (int i = 0; i < OP_INPUTS; i++)
        if (r->in[i])
            put(v, r, "in", i, r->in[i]);
    for (int i = 0; i < r->n_out; i++)
        put(v, r, "dout", i, r->dout[i]);
    lt_run(r->plan);
}

static void compare_outputs(const vectors *v, const op_run *r, bool train)
{
    for (int i = 0; i < r->n_out; i++) {
        const lt_array *infer = train ? NULL : array(v, "infer", i), *want = infer ? infer : array(v, "out", i);

        ck_assert(same_shape(want, r->out[i]));
        expect_near(v, "out", i, want, op_run_data(r, r->out[i]), v->s->value_tol);
    }
}

static void compare_training(vectors *v)
{
    op_run r;

    run_with_vectors(v, &r, &(op_run_opts){ .train = true, .want = OP_ALL_INPUTS });
    compare_outputs(v, &r, true);
    for (int i = 0; i < OP_INPUTS; i++)
        if (op_run_grad(&r, i))
            expect_near(v, "din", i, array(v, "din", i), op_run_grad(&r, i), v->s->grad_tol);
        else
            ck_assert(!array(v, "din", i) || lt_array_count(array(v, "din", i)) == 0);
    op_run_free(&r);
}

static void compare_inference(vectors *v, bool no_fusion)
{
    op_run r;

    run_with_vectors(v, &r, &(op_run_opts){ .no_fusion = no_fusion });
    compare_outputs(v, &r, false);
    op_run_free(&r);
}

START_TEST(values)
{
    vectors v = { .how = "" };
    lt_arena *arena = lt_arena_new();
    char path[256];

    v.c = case_at(_i, &v.s);
    snprintf(path, sizeof(path), "%s/tests/vectors/ops/%s.npz", getenv("srcdir") ? getenv("srcdir") : "..",
             v.s->name);
    if (!v.c->no_vectors) {
        check_ok(lt_npz_read(arena, path, &v.npz));
        for (int isa = LT_ISA_GENERIC; isa <= LT_ISA_AMX; isa++) {
            lt_kernels k;

            if (lt_kernels_get(isa, &k) != LT_OK)
                continue;
            lt_kernels_use(&k);
            v.how = lt_isa_name(isa);
            compare_training(&v);
            compare_inference(&v, false);
            compare_inference(&v, true);
            lt_kernels_use(NULL);
        }
    }
    lt_arena_free(arena);
}
END_TEST

/* The comparison itself: a value that is off, a NaN, and one that is right. */
START_TEST(wrong_values_are_noticed)
{
    const double want[] = { 1, -4, 0 };
    const int64_t shape[] = { 3 };
    const lt_array a = lt_array_make(LT_ELEM_F8, 1, shape, want);
    char why[160];

    ck_assert(near_all(&a, (float[]){ 1, -4, 1e-7f }, 1e-6, why, sizeof(why)));
    ck_assert(!near_all(&a, (float[]){ 1, -4.0001f, 0 }, 1e-6, why, sizeof(why)));
    ck_assert(!near_all(&a, (float[]){ 1, 4, 0 }, 1e-6, why, sizeof(why)));
    ck_assert(!near_all(&a, (float[]){ NAN, -4, 0 }, 1e-6, why, sizeof(why)));
}
END_TEST

/* ---- bits ----------------------------------------------------------------------------------------- */

static void run_filled(op_run *r, const op_suite *s, const op_case *c, const op_run_opts *o)
{
    ck_assert_msg(op_run_new(r, s, c, o), "%s %s: %s", s->name, c->name, lt_last_error());
    op_run_fill(r, 7);
    lt_run(r->plan);
}

static bool same_bits(const lt_tensor *t, const lt_real *a, const lt_real *b)
{
    return !a || !b ? a == b : memcmp(a, b, lt_nbytes(t)) == 0;
}

START_TEST(any_number_of_threads)
{
    const op_run_opts o = { .train = true, .want = OP_ALL_INPUTS };
    const op_suite *s;
    const op_case *c = case_at(_i, &s);
    op_run one, more;

    lt_set_threads(1);
    run_filled(&one, s, c, &o);
    for (int threads = 2; threads <= 4; threads++) {
        lt_set_threads(threads);
        run_filled(&more, s, c, &o);
        for (int i = 0; i < one.n_out; i++)
            ck_assert_msg(same_bits(one.out[i], op_run_data(&one, one.out[i]), op_run_data(&more, more.out[i])),
                          "%s %s: out%d has other bits on %d threads", s->name, c->name, i, threads);
        for (int i = 0; i < OP_INPUTS; i++)
            ck_assert_msg(same_bits(one.in[i], op_run_grad(&one, i), op_run_grad(&more, i)),
                          "%s %s: din%d has other bits on %d threads", s->name, c->name, i, threads);
        op_run_free(&more);
    }
    op_run_free(&one);
}
END_TEST

/* A gradient is the same when it is the only one wanted. */
START_TEST(gradients_one_at_a_time)
{
    const op_suite *s;
    const op_case *c = case_at(_i, &s);
    op_run all, one;

    run_filled(&all, s, c, &(op_run_opts){ .train = true, .want = OP_ALL_INPUTS });
    for (int i = 0; i < OP_INPUTS; i++) {
        if (c->in[i].role != OP_VALUE || c->together)
            continue;
        run_filled(&one, s, c, &(op_run_opts){ .train = true, .want = 1u << i });
        ck_assert_msg(same_bits(all.in[i], op_run_grad(&all, i), op_run_grad(&one, i)),
                      "%s %s: din%d differs when nothing else is wanted", s->name, c->name, i);
        op_run_free(&one);
    }
    op_run_free(&all);
}
END_TEST

/* ---- the same op elsewhere -------------------------------------------------------------------------- */

START_TEST(through_onnx)
{
    const op_suite *s;
    const op_case *c = case_at(_i, &s);

    check_onnx_way(s, c);
}
END_TEST

/* ---- what ops say of wrong shapes ------------------------------------------------------------------ */

START_TEST(bad_input)
{
    const op_suite *s;
    const op_bad_case *b = bad_case_at(_i, &s);
    op_case c = { .build = b->build };
    const char *place;
    op_run r;

    memcpy(c.in, b->in, sizeof(c.in));
    ck_assert_msg(!op_run_new(&r, s, &c, &(op_run_opts){ .train = true }), "accepted: %s", b->message);
    place = strstr(lt_last_error(), " (../tests/ops/");
    if (!place)
        place = strstr(lt_last_error(), " (tests/ops/");
    if (!place)
        place = strstr(lt_last_error(), ".c:");
    ck_assert_msg(place && strncmp(lt_last_error(), b->message, strlen(b->message)) == 0
                  && lt_last_error()[strlen(b->message)] == ' ', "says: %s\nwant: %s", lt_last_error(), b->message);
}
END_TEST

static void print_isas(void)
{
    printf("instruction sets:");
    for (int isa = LT_ISA_GENERIC; isa <= LT_ISA_AMX; isa++) {
        lt_kernels k;

        printf(" %s%s", lt_isa_name(isa), lt_kernels_get(isa, &k) == LT_OK ? "" : " (not here)");
    }
    printf("\n");
}

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_loop_test(tc, values, 0, n_cases());
    tcase_add_test(tc, wrong_values_are_noticed);
    tcase_add_loop_test(tc, any_number_of_threads, 0, n_cases());
    tcase_add_loop_test(tc, gradients_one_at_a_time, 0, n_cases());
    tcase_add_loop_test(tc, through_onnx, 0, n_cases());
    tcase_add_loop_test(tc, bad_input, 0, n_bad_cases());
}

int main(void)
{
    print_isas();
    return run_suite("ops", add_tests);
}
