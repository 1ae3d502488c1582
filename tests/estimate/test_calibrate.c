/* SPDX-License-Identifier: Apache-2.0 */
/* Ranges of layers and what integers cost them, of a small network of which both are known. */
#include "estimate/int8/calibrate.h"

#include "libtensor/base/arena.h"
#include "libtensor/base/rng.h"
#include "libtensor/ops/ops.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { K = 64, BATCHES = 3, ROWS = 40 };

/* plain: in [-1, 1); positive: never negative; spiked: one number in a row is a thousand times the others, and
 * counts for nothing in the result; silent: nothing but zeros. */
static const char *const names[] = { "plain", "positive", "spiked", "silent" };

static lt_param *weights(const model *m, const char *name)
{
    char full[32];

    snprintf(full, sizeof(full), "%s.weight", name);
    return lt_params_find(m->params, full);
}

static void record(const model *m, bool losses, model_record *out)
{
    lt_tensor *y = NULL;

    (void)losses;
    for (size_t i = 0; i < LT_COUNT(names); i++) {
        lt_tensor *x = model_input(out, names[i], LT_SHAPE(ROWS, K));
        lt_tensor *one = lt_linear(x, lt_use(out->g, weights(m, names[i])), NULL);

        y = y ? lt_add(y, lt_tanh(one)) : lt_tanh(one);
    }
    model_port_add(&out->outputs, "y", lt_output(y, "y"));
}

static const model_class cls = { .name = "four", .record = record };

static lt_real number(lt_rng *r, size_t input, int64_t i)
{
    const double x = lt_rng_range(r, -1, 1);

    if (input == 2)
        return (lt_real)(i % K == 7 ? 1000 : x);
    return (lt_real)(input == 3 ? 0 : input == 1 ? fabs(x) : x);
}

static lt_status walk(void *ctx, const lt_plan *p, const model_record *r, void (*run)(void *), void *run_ctx)
{
    int *walks = ctx;
    lt_rng rng = lt_rng_make(11, 0);

    ++*walks;
    for (int b = 0; b < BATCHES; b++) {
        for (int k = 0; k < r->inputs.n; k++) {
            lt_real *x = lt_plan_data(p, r->inputs.port[k].tensor);

            for (int64_t i = 0; i < ROWS * K; i++)
                x[i] = number(&rng, (size_t)k, i);
        }
        run(run_ctx);
    }
    return LT_OK;
}

static lt_status stop(void *ctx, const lt_plan *p, const model_record *r, void (*run)(void *), void *run_ctx)
{
    (void)ctx, (void)p, (void)r, (void)run, (void)run_ctx;
    return lt_error(LT_ESTOPPED, "stopped");
}

static void four_layers(model *m)
{
    lt_rng rng = lt_rng_make(12, 0);

    *m = (model){ .cls = &cls, .params = lt_params_new(), .variant = "" };
    for (size_t i = 0; i < LT_COUNT(names); i++) {
        lt_param *w = lt_params_add(m->params, names[i], "weight", LT_WEIGHT, LT_SHAPE(K, K));

        for (int64_t k = 0; k < K * K; k++)
            w->data[k] = (lt_real)(i == 2 && k % K == 7 ? 0 : lt_rng_range(&rng, -0.1, 0.1));
    }
}

START_TEST(ranges)
{
    lt_arena *arena = lt_arena_new();
    int walks = 0;
    calibration c;
    model m;

    four_layers(&m);
    ck_assert_int_eq(calibrate(arena, &(calibrate_options){ .m = &m, .batch = 1, .walk = walk, .ctx = &walks }, &c),
                     LT_OK);
    ck_assert_int_eq(walks, 2);
    ck_assert_int_eq(c.n, 4);
    for (int i = 0; i < c.n; i++)
        ck_assert_str_eq(c.layer[i].layer, names[i]);
    ck_assert(c.layer[0].range.has_negative && !c.layer[1].range.has_negative);
    /* even numbers are not cut off */
    ck_assert_double_eq_tol((double)c.layer[0].range.scale, 1.0 / 127, 0.03 / 127);
    ck_assert_double_eq_tol((double)c.layer[1].range.scale, 1.0 / 255, 0.03 / 255);
    ck_assert_double_gt(c.layer[0].db, 35);
    ck_assert_double_gt(c.layer[1].db, 35);
    ck_assert(c.layer[0].integers && c.layer[1].integers);
    ck_assert(!c.layer[2].integers && c.layer[2].db < CALIBRATE_LEAST_DB);
    ck_assert(!c.layer[3].integers && c.layer[3].range.scale == 0);
    ck_assert_int_eq(c.table.n, 2);
    ck_assert_ptr_nonnull(lt_int8_find(&c.table, "plain"));
    ck_assert_ptr_null(lt_int8_find(&c.table, "spiked"));
    lt_params_free(m.params);
    lt_arena_free(arena);
}
END_TEST

START_TEST(printed)
{
    lt_arena *arena = lt_arena_new();
    char *text = NULL;
    int walks = 0;
    calibration c;
    size_t n;
    FILE *f;
    model m;

    four_layers(&m);
    ck_assert_int_eq(calibrate(arena, &(calibrate_options){ .m = &m, .batch = 1, .walk = walk, .ctx = &walks }, &c),
                     LT_OK);
    f = open_memstream(&text, &n);
    calibration_print(&c, f);
    fclose(f);
    ck_assert_ptr_nonnull(strstr(text, "2 of 4 layers read 8-bit integers"));
    ck_assert_ptr_nonnull(strstr(text, "silent                                   stays float: nothing but zeros came "
                                 "in"));
    ck_assert_ptr_nonnull(strstr(text, " dB, want 20"));
    free(text);
    lt_params_free(m.params);
    lt_arena_free(arena);
}
END_TEST

START_TEST(walk_that_fails)
{
    lt_arena *arena = lt_arena_new();
    calibration c;
    model m;

    four_layers(&m);
    ck_assert_int_eq(calibrate(arena, &(calibrate_options){ .m = &m, .batch = 1, .walk = stop }, &c), LT_ESTOPPED);
    lt_params_free(m.params);
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_test(c, ranges);
    tcase_add_test(c, printed);
    tcase_add_test(c, walk_that_fails);
}

int main(void)
{
    return run_suite("calibrate", add_tests);
}
