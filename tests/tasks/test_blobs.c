/* SPDX-License-Identifier: Apache-2.0 */
/* A task with all that hurts, on the trainer: the same bits on any number of threads, and after any stop. */
#include "libtensor/base/parallel.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"
#include "tests/tasks/blobs/blobs.h"
#include "train/trainer.h"

#include <signal.h>

static const task *const tasks[] = { &blobs_task, NULL };
static lt_arena *arena;

static const char *at(const char *path)
{
    return lt_arena_printf(arena, "%s/%s", scratch_folder, path);
}

static void setup(void)
{
    static const char config[] = "{ \"model\": { \"name\": \"blobs\" }, \"train\": { \"validate_steps\": 30, "
        "\"validate_every\": 0, \"checkpoint_minutes\": 0 }, \"data\": { \"threads\": 2 } }";

    make_scratch_folder();
    arena = lt_arena_new();
    ck_assert_ptr_nonnull(arena);
    check_ok(lt_write_file(at("blobs.json"), config, sizeof(config) - 1));
}

static void teardown(void)
{
    lt_arena_free(arena);
    remove_scratch_folder();
}

static train_options options(const char *out)
{
    return (train_options){ .tasks = tasks, .config = at("blobs.json"), .out = at(out), .quiet = true };
}

static const char *last_of(const char *run)
{
    return at(lt_arena_printf(arena, "%s/checkpoints/last.safetensors", run));
}

static void same_end(const char *a, const char *b)
{
    uint8_t *x, *y;
    size_t n, m;

    check_ok(lt_read_file(arena, last_of(a), LT_FILE_MAX, &x, &n));
    check_ok(lt_read_file(arena, last_of(b), LT_FILE_MAX, &y, &m));
    ck_assert_uint_eq(n, m);
    ck_assert_msg(memcmp(x, y, n) == 0, "%s and %s differ", a, b);
}

START_TEST(threads_do_not_matter)
{
    for (int threads = 1; threads <= 4; threads++) {
        const char *out = lt_arena_printf(arena, "threads%d", threads);
        const train_options o = options(out);

        lt_set_threads(threads);
        check_ok(train_run(&o, NULL));
        same_end("threads1", out);
    }
}
END_TEST

static void raise_at(void *ctx, int64_t step, lt_params *params)
{
    (void)params;
    if (step == *(const int64_t *)ctx)
        raise(SIGTERM);
}

/* Before a growth, at one, behind it, where a phase begins, and where both capacity and phase have changed */
START_TEST(stops_do_not_matter)
{
    static const int64_t stops[] = { 19, 20, 21, 40, 41, 50, 51, 61, 100, 119 };
    train_options o = options("whole");
    int64_t stop;

    check_ok(train_run(&o, NULL));
    o.out = at("stopped");
    o.before_step = raise_at;
    o.ctx = &stop;
    for (size_t i = 0; i < LT_COUNT(stops); i++) {
        stop = stops[i];
        ck_assert_int_eq(train_run(&o, NULL), LT_ESTOPPED);
        o.config = NULL;
        o.resume = "";
    }
    stop = -1;
    check_ok(train_run(&o, NULL));
    same_end("whole", "stopped");
}
END_TEST

START_TEST(blobs_are_found)
{
    const train_options o = options("run");
    train_result r;
    lt_safetensors f;
    uint8_t *csv;
    size_t n;

    check_ok(train_run(&o, &r));
    ck_assert_int_eq(r.step, 120);
    ck_assert_int_eq(r.skipped, 0);
    ck_assert_msg(r.best > 0.4 && r.best <= 1, "average precision %g", r.best);
    check_ok(lt_read_file(arena, at("run/metrics.csv"), LT_FILE_MAX, &csv, &n));
    ck_assert_msg(n > 50 && !memcmp(csv, "step,epoch,samples,blobs_ap,loss,picture\n30,", 43), "%.60s", (char *)csv);
    check_ok(lt_safetensors_read(arena, last_of("run"), &f));
    ck_assert_int_eq(lt_safetensors_find(&f, "blobs.centre")->shape[0], 3 * 8);     /* it grew */
    ck_assert_int_eq(lt_safetensors_find(&f, "optim.m.blobs.centre")->shape[0], 3 * 8);
    ck_assert_int_eq(lt_safetensors_find(&f, "task.slope")->shape[0], 3 * 8);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, threads_do_not_matter);
    tcase_add_test(tc, stops_do_not_matter);
    tcase_add_test(tc, blobs_are_found);
}

int main(void)
{
    return run_suite("blobs", add_tests);
}
