/* SPDX-License-Identifier: Apache-2.0 */
/* The table of dataset kinds, and a kind that is in no table and has no folder. */
#include "data/check.h"
#include "data/kind.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static lt_arena *arena;

static void set_up(void) { arena = lt_arena_new(); }
static void tear_down(void) { lt_arena_free(arena); }

/* ---- samples that are drawn when they are read ---- */

static lt_status draw(const dataset *d, int64_t index, unsigned want, lt_arena *to, dataset_sample *out)
{
    uint8_t *rgb = lt_arena_alloc(to, 4 * 4 * 3);

    (void)want;
    if (!rgb)
        return lt_error(LT_ENOMEM, "%s: no memory", d->root);
    memset(rgb, (int)index, 4 * 4 * 3);
    *out = (dataset_sample){ .name = "drawn", .width = 4, .height = 4, .rgb = rgb, .camera = { 5, 5, 2, 2 },
                             .object = -1 };
    return LT_OK;
}

static lt_status draw_annotation(const dataset *d, int64_t index, lt_arena *to, dataset_sample *out)
{
    return draw(d, index, 0, to, out);
}

static const char *nothing_missing(const dataset *d, int64_t index, lt_arena *to)
{
    (void)d, (void)index, (void)to;
    return NULL;
}

static const char *drawn_name(const dataset *d, int64_t index)
{
    (void)d, (void)index;
    return "drawn";
}

static void nothing_to_free(dataset *d) { (void)d; }

static lt_status open_drawn(const dataset_options *o, dataset **out)
{
    static const dataset_ops ops = { draw, draw_annotation, nothing_missing, drawn_name, nothing_to_free };
    static dataset d;

    d = (dataset){ .ops = &ops, .kind = o->kind, .title = "drawn", .split = o->split, .root = "drawn", .count = 3 };
    *out = &d;
    return LT_OK;
}

static const char *const drawn_splits[] = { "train", NULL };
static const dataset_kind drawn_kind = {
    .title = "drawn", .splits = drawn_splits, .counted = "samples", .fields = SAMPLE_DEPTH, .open = open_drawn,
};

/* It is opened by those who ask for it, read like any other, and stands the self-test. */
START_TEST(no_folder)
{
    const dataset_options o = { .kind = &drawn_kind, .split = "train", .needs = SAMPLE_DEPTH };
    check_missing missing;
    check_samples read;
    dataset_sample s;
    dataset *d;

    check_ok(dataset_open(&o, &d));
    check_ok(dataset_read(d, 2, 0, arena, &s));
    ck_assert_int_eq(s.rgb[0], 2);
    ck_assert_int_eq(dataset_read(d, 3, 0, arena, &s), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "drawn: no sample 3, there are 3");
    check_ok(check_files(d, arena, &missing));
    check_ok(check_read(d, 0, arena, &read));
    ck_assert_int_eq(missing.samples, 0);
    ck_assert_int_eq(read.read, 3);
    ck_assert_int_eq(read.bad, 0);
    ck_assert_ptr_null(dataset_validation_split(&drawn_kind, NULL));
    dataset_free(d);
}
END_TEST

START_TEST(needs_what_it_has_not)
{
    const dataset_options o = { .kind = &drawn_kind, .split = "train", .needs = SAMPLE_DEPTH | SAMPLE_JOINTS };
    dataset *d;

    ck_assert_int_eq(dataset_open(&o, &d), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "data: drawn has no hand joints, which are needed here");
}
END_TEST

/* ---- the table ---- */

static const char *folder_with(const char *name)
{
    const char *root = lt_arena_printf(arena, "kinds-%d", (int)getpid());
    const char *path = lt_arena_printf(arena, "%s/%s", root, name);

    check_ok(lt_make_dirs(root));
    check_ok(lt_write_file(path, "", 0));
    return root;
}

static void remove_folder(const char *root, const char *name)
{
    unlink(lt_arena_printf(arena, "%s/%s", root, name));
    rmdir(root);
}

START_TEST(known_by_the_folder)
{
    static const struct { const char *name, *title; } cases[] = {
        { "train.txt", "HO3D" }, { "evaluation.txt", "HO3D" }, { "calibration", "DexYCB" },
        { "20200709-subject-01", "DexYCB" },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        const char *root = folder_with(cases[i].name);
        const dataset_kind *kind;

        check_ok(dataset_find_kind(root, &kind));
        ck_assert_str_eq(kind->title, cases[i].title);
        remove_folder(root, cases[i].name);
    }
}
END_TEST

START_TEST(of_no_kind)
{
    const char *root = folder_with("notes.md");
    const dataset_kind *kind;

    ck_assert_int_eq(dataset_find_kind(root, &kind), LT_EIO);
    ck_assert_str_eq(lt_last_error(), lt_arena_printf(arena, "%s: neither train.txt and evaluation.txt, as HO3D has "
                     "them, nor folders like 20200709-subject-01, as DexYCB has them", root));
    remove_folder(root, "notes.md");
    ck_assert_int_eq(dataset_find_kind(root, &kind), LT_EIO);
    ck_assert_str_eq(lt_last_error(), lt_arena_printf(arena, "%s: No such file or directory; give the folder of a "
                     "dataset, or make a synthetic one with `palmar synth`", root));
}
END_TEST

START_TEST(validates_where_there_is_truth)
{
    const char *root = folder_with("evaluation.txt");
    const dataset_kind *kind;

    check_ok(dataset_find_kind(root, &kind));
    ck_assert_ptr_null(dataset_validation_split(kind, root));
    folder_with("evaluation_xyz.json");
    ck_assert_str_eq(dataset_validation_split(kind, root), "evaluation");
    remove_folder(root, "evaluation.txt");
    remove_folder(root, "evaluation_xyz.json");
}
END_TEST

START_TEST(in_words)
{
    static const char *const want[] = {
        [DATASET_TITLES] = "HO3D or DexYCB", [DATASET_SETUPS] = "DexYCB: s0, s1, s2 or s3",
        [DATASET_FILTERS] = "DexYCB: valid, every, hfl-net or hoisdf", [DATASET_WITH_SETUPS] = "DexYCB",
    };
    char list[DATASET_LIST];

    for (size_t i = 0; i < LT_COUNT(want); i++) {
        dataset_list_kinds((dataset_list)i, list);
        ck_assert_str_eq(list, want[i]);
    }
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, set_up, tear_down);
    tcase_add_test(c, no_folder);
    tcase_add_test(c, needs_what_it_has_not);
    tcase_add_test(c, known_by_the_folder);
    tcase_add_test(c, of_no_kind);
    tcase_add_test(c, validates_where_there_is_truth);
    tcase_add_test(c, in_words);
}

int main(void)
{
    setenv("CK_FORK", "no", 1);         /* the threads that parallel loops leave do not survive a fork */
    return run_suite("kinds", add_tests);
}
