/* SPDX-License-Identifier: Apache-2.0 */
/* LPIPS of pictures: what is around a smaller one does not matter, weights come in one file or two, and what lacks some
 * says so. */
#include "eval/metrics/lpips_score.h"
#include "libtensor/graph/plan.h"
#include "libtensor/io/array/safetensors.h"
#include "tests/geometry/hashed.h"
#include "tests/suite.h"

#include <math.h>

enum { H = 40, W = 50, LARGE = 80, PARAMS = 15 };

static float a[3 * H * W], b[3 * H * W];
static const eval_pictures pictures = { .a = a, .b = b, .channels = 3, .height = H, .width = W, .plane = H * W,
                                        .row = W };
static lt_arena *arena;
static lt_params *params;
static lpips network;

static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
    params = lt_params_new();
    lpips_new(&network, params, "");
    lpips_init(&network);
    for (uint32_t i = 0; i < 3 * H * W; i++) {
        a[i] = (float)(hashed(1, i) / 2 + 0.5);
        b[i] = (float)(hashed(2, i) / 2 + 0.5);
    }
}

static void teardown(void)
{
    lt_params_free(params);
    lt_arena_free(arena);
    remove_scratch_folder();
}

static eval_lpips *of(const eval_lpips_options *o)
{
    eval_lpips *s;

    check_ok(eval_lpips_new(o, &s));
    return s;
}

/* What lpips_distance says of whole pictures of their own size */
static double distance(lpips_range range)
{
    lt_graph *g = lt_graph_new();
    const int64_t shape[] = { 1, 3, H, W };
    lt_tensor *x = lt_input(g, "x", LT_F32, 4, shape), *y = lt_input(g, "y", LT_F32, 4, shape);
    lt_tensor *out = lt_output(lpips_distance(&network, range, x, y, NULL), "distance");
    lt_plan *p = lt_compile(g, &(lt_compile_opts){ 0 });
    double far;

    ck_assert_msg(p != NULL, "%s", lt_last_error());
    memcpy(lt_plan_data(p, x), a, sizeof(a));
    memcpy(lt_plan_data(p, y), b, sizeof(b));
    lt_run(p);
    far = (double)*(const lt_real *)lt_plan_data(p, out);
    lt_plan_free(p);
    lt_graph_free(g);
    return 1e3 * far;
}

START_TEST(of_any_size)
{
    const eval_lpips_options sizes[] = { { .network = &network, .height = H, .width = W },
                                         { .network = &network, .height = LARGE, .width = LARGE },
                                         { .height = LARGE, .width = W } };
    eval_lpips *s = of(&sizes[_i]);
    const eval_lpips_scores far = eval_lpips_score(s, &pictures);

    ck_assert(far.sym > 0);
    ck_assert_double_eq(far.raw01, distance(LPIPS_RAW01));
    ck_assert_double_eq(far.sym, distance(LPIPS_SYM));
    ck_assert_str_eq(eval_lpips_name(s), "lpips (random trunk)");
    eval_lpips_free(s);
}
END_TEST

/* Some of the parameters, other than lpips_init makes them, into a file */
static const char *write_weights(const char *name, bool trunk, bool lin)
{
    const char *path = lt_arena_printf(arena, "%s", in_folder(name));
    lt_named_array list[PARAMS];
    size_t n = 0;

    for (lt_param *p = lt_params_first(params); p; p = p->next) {
        const bool is_lin = strncmp(p->name, "lin", 3) == 0;

        for (int64_t i = 0; i < lt_param_numel(p); i++)
            p->data[i] = (lt_real)(0.01 * (is_lin ? fabs(hashed(3, (uint32_t)i)) : hashed(4, (uint32_t)i)));
        if (is_lin ? lin : trunk)
            list[n++] = (lt_named_array){ p->name, lt_array_make(LT_ELEM_F4, p->shape.rank, p->shape.dim, p->data) };
    }
    check_ok(lt_safetensors_write(path, list, n, NULL, 0));
    return path;
}

START_TEST(weights_in_files)
{
    const char *const whole[] = { write_weights("whole", true, true) };
    const char *const apart[] = { write_weights("trunk", true, false), write_weights("lin", false, true) };
    eval_lpips_options o = { .height = H, .width = W, .file = whole, .n_files = 1 };
    eval_lpips *s = of(&o);

    ck_assert_str_eq(eval_lpips_name(s), "lpips");
    ck_assert_double_eq(eval_lpips_score(s, &pictures).sym, distance(LPIPS_SYM));
    eval_lpips_free(s);
    o.file = apart;
    s = of(&o);
    ck_assert_str_eq(eval_lpips_name(s), "lpips (random trunk)");
    eval_lpips_free(s);
    o.n_files = 2;
    s = of(&o);
    ck_assert_str_eq(eval_lpips_name(s), "lpips");
    ck_assert_double_eq(eval_lpips_score(s, &pictures).sym, distance(LPIPS_SYM));
    eval_lpips_free(s);
}
END_TEST

START_TEST(what_is_wrong)
{
    const char *const none[] = { "/nowhere/lpips.pth" };
    eval_lpips *s;

    ck_assert_int_eq(eval_lpips_new(&(eval_lpips_options){ .file = none, .n_files = 1, .height = H, .width = W }, &s),
                     LT_EIO);
    ck_assert_ptr_null(s);
    eval_lpips_free(s);
    ck_assert(eval_lpips_takes(31, 4096) && !eval_lpips_takes(30, 100) && !eval_lpips_takes(100, 4097));
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_set_timeout(t, 60);
    tcase_add_loop_test(t, of_any_size, 0, 3);
    tcase_add_test(t, weights_in_files);
    tcase_add_test(t, what_is_wrong);
}

int main(void)
{
    return run_suite("lpips score", add_tests);
}
