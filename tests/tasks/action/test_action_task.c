/* SPDX-License-Identifier: Apache-2.0 */
/* Learning actions from a few clips: bits do not depend on threads or stops, it learns, and it is scored by hand. */
#include "libtensor/base/parallel.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "synth/generate.h"
#include "tasks/action/scores.h"
#include "tasks/action/task.h"
#include "tests/scratch.h"
#include "train/trainer.h"

#include <math.h>
#include <signal.h>

static const task *const tasks[] = { &action_task, NULL };

static void setup(void)
{
    static const char config[] = "{ \"model\": { \"name\": \"action\", \"frames\": 12, \"kernel\": 5 }, \"optim\": { "
        "\"kind\": \"adam\", \"lr\": 1e-3, \"schedule\": \"constant\", \"batch\": 6, \"shards\": 2, \"steps\": 3 }, "
        "\"train\": { \"checkpoint_minutes\": 0, \"validate_every\": 0, \"validate_samples\": 20 }, \"data\": { "
        "\"windows\": 2, \"min_valid\": 4 } }";

    open_scratch();
    check_ok(synth_generate(&(synth_options){ .preset = SYNTH_ACTIONS, .out = at("data"), .clips = 100 }, NULL, NULL));
    check_ok(lt_write_file(at("action.json"), config, sizeof(config) - 1));
}

static lt_status train(const char *out, const char *more, const char *resume,
                       void (*before_step)(void *, int64_t, lt_params *), train_result *result)
{
    const char *set[] = { lt_arena_printf(arena, "data.dir=%s/data", scratch_folder), more, "train.validate_steps=60",
                          "optim.batch=16", "optim.shards=1" };
    train_options o = { .tasks = tasks, .config = resume ? NULL : at("action.json"), .out = at(out), .quiet = true,
                        .resume = resume, .before_step = before_step, .set = set,
                        .n_set = resume ? 0 : more ? (int)LT_COUNT(set) : 1 };

    return train_run(&o, result);
}

static void stop_at_second(void *ctx, int64_t step, lt_params *set)
{
    (void)ctx, (void)set;
    if (step == 2)
        raise(SIGTERM);
}

START_TEST(threads_and_stops_do_not_matter)
{
    lt_set_threads(1);
    check_ok(train("whole", NULL, NULL, NULL, NULL));
    lt_set_threads(2);
    check_ok(train("threads", NULL, NULL, NULL, NULL));
    same_end("whole", "threads");
    ck_assert_int_eq(train("stopped", NULL, NULL, stop_at_second, NULL), LT_ESTOPPED);
    check_ok(train("stopped", NULL, "", NULL, NULL));
    same_end("whole", "stopped");
}
END_TEST

/* Far more than a tenth of what it never saw */
START_TEST(it_learns)
{
    train_result r;

    check_ok(train("learns", "optim.steps=60", NULL, NULL, &r));
    ck_assert_msg(r.best > 0.25, "accuracy %g", r.best);
}
END_TEST

START_TEST(scores)
{
    action_confusion c = { { { 0 } } };

    ck_assert(isnan(action_accuracy(&c)) && action_share_3_as_7(&c) == 0);
    for (int i = 0; i < 6; i++)
        action_confusion_add(&c, 2, i < 3 ? 2 : i < 5 ? 6 : 0);
    action_confusion_add(&c, 6, 2);
    action_confusion_add(&c, 9, 9);
    ck_assert_double_eq(action_accuracy(&c), 0.5);
    ck_assert_double_eq(action_recall(&c, 2), 0.5);
    ck_assert(isnan(action_recall(&c, 0)));
    ck_assert_double_eq(action_share_3_as_7(&c), 0.5);
    ck_assert(isnan(action_object_recall(&c)));         /* of two of the four there is no window */
    action_confusion_add(&c, 7, 7);
    action_confusion_add(&c, 8, 7);
    ck_assert_double_eq(action_object_recall(&c), 0.5);
}
END_TEST

/* What palmar report shows */
START_TEST(page)
{
    action_scores s = { .baseline = NAN, .split = "subject", .synthetic = true };
    uint8_t *text;
    size_t n;

    for (int i = 0; i < ACTION_CLASSES; i++) {
        action_confusion_add(&s.both, i, i);
        action_confusion_add(&s.body_only, i, i < 8 ? i : 0);
        action_confusion_add(&s.hand_object_only, i, i);
    }
    check_ok(action_scores_page(&s, scratch_folder));
    check_ok(lt_read_file(arena, at("table.md"), LT_FILE_MAX, &text, &n));
    ck_assert_ptr_nonnull(strstr((char *)text, "\n| both streams | 1.0000 | 1.0000 |\n"
                                               "| the body alone | 0.8000 | 0.5000 |\n"));
    ck_assert_ptr_nonnull(strstr((char *)text, "| 1.0000 | 0.0000 | 0 | 0 | 0 | 0 | 0 | 0 | 0 | 0 | 0 | 1 "
                                               "|\n\nProtocol: SYNTHETIC, 10 windows, split by subject"));
}
END_TEST

START_TEST(refused)
{
    train_result r;

    check_error(train("side", "data.held_out=40", NULL, NULL, &r), LT_EINVAL,
                "no clip to score: subject 40 is held out");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 300);
    tcase_add_checked_fixture(tc, setup, close_scratch);
    tcase_add_test(tc, threads_and_stops_do_not_matter);
    tcase_add_test(tc, it_learns);
    tcase_add_test(tc, scores);
    tcase_add_test(tc, page);
    tcase_add_test(tc, refused);
}

int main(void)
{
    return run_suite("action", add_tests);
}
