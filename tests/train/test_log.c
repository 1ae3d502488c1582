/* SPDX-License-Identifier: Apache-2.0 */
/* What a run writes down: lines that can be read, torn ones cut off, spikes noticed; and progress off a terminal. */
#define _GNU_SOURCE                     /* memmem */
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"
#include "train/log.h"
#include "train/progress.h"

#include <dirent.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static lt_arena *arena;

static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
}

static void teardown(void)
{
    remove_scratch_folder();
    lt_arena_free(arena);
}

static void put(const char *name, const char *text)
{
    put_file(in_folder(name), text, strlen(text));
}

static const char *get(const char *name)
{
    uint8_t *bytes;
    size_t n;

    check_ok(lt_read_file(arena, in_folder(name), LT_FILE_MAX, &bytes, &n));
    return (const char *)bytes;
}

static const train_step_record one_step = {
    .step = 3, .epoch = 1, .loss = 0.25, .part_name = { "a", "b" }, .part = { 0.125, NAN }, .n_parts = 2,
    .lr = 1e-4, .grad_norm = INFINITY, .img_per_s = 2, .seconds = 8, .ms = 500,
    .phase = "joint", .count = { { "gaussians", 7 } }, .n_counts = 1, .bad = "conv2d \"x\"",
};

START_TEST(cut_and_append)
{
    train_log l;

    put("log.jsonl", "{\"step\":1,\"x\":1}\n{\"step\":2,\"x\":1}\n{\"step\":3,\"x\":1}\n{\"step\":4,\"x");
    put("metrics.csv", "step,pa\n2,1.5\n4,1.25\n6,1.");
    ck_assert_int_eq(train_log_open(arena, scratch_folder, 2, &l), LT_OK);
    train_log_step(&l, &one_step);
    ck_assert_int_eq(train_log_flush(&l), LT_OK);
    train_log_close(&l);
    ck_assert_str_eq(get("log.jsonl"), "{\"step\":1,\"x\":1}\n{\"step\":2,\"x\":1}\n"
                     "{\"step\":3,\"epoch\":1,\"loss\":0.25,\"parts\":{\"a\":0.125,\"b\":null},\"lr\":0.0001,"
                     "\"grad_norm\":null,\"img_per_s\":2,\"seconds\":8,\"ms\":500,\"phase\":\"joint\",\"gaussians\":7,"
                     "\"skipped\":\"conv2d \\\"x\\\"\"}\n");
    ck_assert_str_eq(get("metrics.csv"), "step,pa\n2,1.5\n");
}
END_TEST

/* Only the last line is torn: all before it stay. */
START_TEST(torn)
{
    train_log l;

    put("log.jsonl", "{\"step\":1}\n{\"step\":2}\n{\"st");
    ck_assert_int_eq(train_log_open(arena, scratch_folder, 100, &l), LT_OK);
    train_log_close(&l);
    ck_assert_str_eq(get("log.jsonl"), "{\"step\":1}\n{\"step\":2}\n");
}
END_TEST

#define METRICS                                                                                     \
    .metric = { metric_find("pa_mpjpe_mm"), metric_find("mpjpe_mm") }, .value = { 8.5, 20 }, .n_metrics = 2

START_TEST(validation_lines)
{
    const train_validation v = { .step = 7, .epoch = 2, .samples = 5, METRICS,
                                 .loss = NAN, .part_name = { "a" }, .part = { NAN }, .n_parts = 1 };
    train_log l;

    ck_assert_int_eq(train_log_open(arena, scratch_folder, 0, &l), LT_OK);
    train_log_validation(&l, &v);
    train_log_validation(&l, &v);
    train_log_close(&l);
    ck_assert_str_eq(get("metrics.csv"), "step,epoch,samples,pa_mpjpe_mm,mpjpe_mm,loss,a\n7,2,5,8.5,20,,\n"
                     "7,2,5,8.5,20,,\n");
    ck_assert_ptr_nonnull(strstr(get("log.jsonl"), "{\"step\":7,\"epoch\":2,\"samples\":5,\"pa_mpjpe_mm\":8.5,"));
}
END_TEST

/* All of a folder's only file, whatever its name */
static const char *only_file(const char *folder, size_t *n)
{
    DIR *d = opendir(in_folder(folder));
    const char *path = NULL;
    uint8_t *bytes;

    ck_assert_ptr_nonnull(d);
    for (struct dirent *e; (e = readdir(d)); )
        if (e->d_name[0] != '.') {
            ck_assert_ptr_null(path);
            path = lt_arena_printf(arena, "%s/%s/%s", scratch_folder, folder, e->d_name);
        }
    closedir(d);
    ck_assert_ptr_nonnull(path);
    ck_assert_ptr_nonnull(strstr(path, "/events.out.tfevents."));
    ck_assert_int_eq(lt_read_file(arena, path, LT_FILE_MAX, &bytes, n), LT_OK);
    return (const char *)bytes;
}

START_TEST(curves_for_tensorboard)
{
    const train_validation v = { .step = 3, METRICS, .loss = NAN };
    static const char *const there[] = { "train/loss", "train/a", "train/lr", "train/img_per_s",
                                         "validation/pa_mpjpe_mm", "validation/mpjpe_mm" };
    static const char *const absent[] = { "train/b", "train/grad_norm", "validation/loss" };    /* not finite */
    const char *bytes;
    train_log l;
    size_t n;

    ck_assert_int_eq(train_log_open(arena, scratch_folder, 0, &l), LT_OK);
    train_log_step(&l, &one_step);
    train_log_validation(&l, &v);
    ck_assert_int_eq(train_log_flush(&l), LT_OK);
    train_log_close(&l);
    bytes = only_file("tb", &n);
    for (size_t i = 0; i < LT_COUNT(there); i++)
        ck_assert_msg(memmem(bytes, n, there[i], strlen(there[i])), "no curve %s", there[i]);
    for (size_t i = 0; i < LT_COUNT(absent); i++)
        ck_assert_msg(!memmem(bytes, n, absent[i], strlen(absent[i])), "a curve %s", absent[i]);
}
END_TEST

START_TEST(spikes)
{
    train_log l = { .n_norms = 0 };

    ck_assert_double_eq(train_log_spike(&l, 1e9), 0);           /* too early to tell */
    for (int i = 0; i < 300; i++)
        ck_assert_double_eq(train_log_spike(&l, 1 + 0.01 * (i % 10)), 0);
    ck_assert_double_eq(train_log_spike(&l, 90), 0);
    ck_assert_double_gt(train_log_spike(&l, 500), 100);
}
END_TEST

START_TEST(plain_progress)
{
    const train_progress_state s = { .epochs = 70, .step_of_epoch = 412, .steps_of_epoch = 1031,
                                     .eta_seconds = 8040, .skipped = 2 };
    char text[512] = "";
    train_progress p;
    FILE *f = tmpfile();

    progress_init(&p, f, false);
    progress_step(&p, &one_step, &s, true);
    progress_step(&p, &one_step, &s, false);                    /* not ten seconds later */
    progress_warn(&p, "%d", 7);
    progress_fini(&p);
    progress_init(&p, f, true);
    progress_step(&p, &one_step, &s, true);
    progress_note(&p, "not when quiet");
    progress_fini(&p);
    rewind(f);
    ck_assert_uint_gt(fread(text, 1, sizeof(text) - 1, f), 0);
    ck_assert_str_eq(text, "epoch 2/70  step 412/1031  loss 0.25  lr 0.0001  2.0 img/s  ETA 2h14m  skipped 2"
                     "  (a 0.125 b nan)\nwarning: 7\n");
    fclose(f);
}
END_TEST

/* Each line begins with its time: "2026-01-31 23:59:59  " */
static void ck_said(const char *text, const char *const *lines, int n)
{
    int year, month, day, hour, minute, second;

    for (int i = 0; i < n; i++, text += strcspn(text, "\n") + 1) {
        ck_assert_int_eq(sscanf(text, "%4d-%2d-%2d %2d:%2d:%2d  ", &year, &month, &day, &hour, &minute, &second), 6);
        ck_assert_uint_eq(strcspn(text + 21, "\n"), strlen(lines[i]));
        ck_assert_mem_eq(text + 21, lines[i], strlen(lines[i]));
    }
    ck_assert_str_eq(text, "");
}

/* Those of before there was a folder, those that quiet keeps from the screen, and an earlier start's stay. */
START_TEST(notes_are_kept)
{
    static const char *const lines[] = { "a model", "warning: 7", "ended: full", "again" };
    const char *path = in_folder("stderr.log");
    train_progress p;
    FILE *f = tmpfile();

    progress_init(&p, f, true);
    progress_note(&p, "a %s", "model");
    check_ok(progress_keep(&p, path));
    progress_warn(&p, "%d", 7);
    progress_log(&p, "ended: %s", "full");
    progress_fini(&p);
    progress_init(&p, f, false);
    progress_note(&p, "again");
    check_ok(progress_keep(&p, path));
    progress_fini(&p);
    ck_said(get("stderr.log"), lines, LT_COUNT(lines));
    progress_init(&p, f, true);
    check_error(progress_keep(&p, in_folder("none/stderr.log")), LT_EIO, "No such file");
    progress_fini(&p);
    fclose(f);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, setup, teardown);
    tcase_add_test(c, cut_and_append);
    tcase_add_test(c, torn);
    tcase_add_test(c, validation_lines);
    tcase_add_test(c, curves_for_tensorboard);
    tcase_add_test(c, spikes);
    tcase_add_test(c, plain_progress);
    tcase_add_test(c, notes_are_kept);
}

int main(void)
{
    return run_suite("log", add_tests);
}
