/* SPDX-License-Identifier: Apache-2.0 */
/* Means by joint, object and sequence. The errors are such that no similarity makes them smaller. */
#include "tasks/hand_object/breakdown.h"

#include "libtensor/io/file.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double truth[3 * LT_HAND_KEYPOINTS];
static lt_arena *arena;

static const char *read_back(const char *name)
{
    uint8_t *bytes;
    size_t n;

    check_ok(lt_read_file(arena, in_folder(name), LT_FILE_MAX, &bytes, &n));
    return (const char *)bytes;
}

static void has(const char *text, const char *line)
{
    ck_assert_msg(strstr(text, line), "no \"%s\" in\n%s", line, text);
}

/* The truth, all of it moved by x metres, and the tip of the index by 0.012 more. */
static void add(eval_breakdown *b, const char *name, const char *object, double x, double add_m)
{
    double joints[3 * LT_HAND_KEYPOINTS];
    const eval_breakdown_sample s = {
        .name = name, .object = object, .joints = joints, .truth = truth, .add = add_m, .add01 = add_m < 0.02,
    };

    memcpy(joints, truth, sizeof(joints));
    for (int i = 0; i < LT_HAND_KEYPOINTS; i++)
        joints[3 * i] += x;
    joints[3 * 8 + 2] += 0.012;
    ck_assert_int_eq(eval_breakdown_add(b, &s), LT_OK);
}

static void start(void)
{
    arena = lt_arena_new();
    make_scratch_folder();
    for (int i = 0; i < 3 * LT_HAND_KEYPOINTS; i++)
        truth[i] = 0.1 * sin(1.7 * i) + 0.5;
}

static void stop(void)
{
    lt_arena_free(arena);
    remove_scratch_folder();
}

/* Wrist on wrist only the tip errs, by 12 mm: a 21st of it in the mean. */
START_TEST(groups)
{
    eval_breakdown *b = eval_breakdown_new(arena);
    const char *text;

    add(b, "A/0001", "003_cracker_box", 0.01, 0.01);
    add(b, "A/0002", "003_cracker_box", 0.02, 0.03);
    add(b, "B/0001", "025_mug", 0, INFINITY);
    add(b, "A/0003", NULL, 0, 0);
    ck_assert_int_eq(eval_breakdown_write(b, scratch_folder), LT_OK);
    text = read_back("per-joint.csv");
    has(text, "joint,pa_mpjpe_mm,mpjpe_mm\nwrist,");
    has(text, ",0\nthumb CMC,");
    has(text, ",12\nmiddle MCP,");
    text = read_back("per-object.csv");
    has(text, "object,pa_mpjpe_mm,mpjpe_mm,add_mm,add01_percent,samples\n003_cracker_box,");
    has(text, ",0.5714286,20,50,2\n025_mug,");
    has(text, ",0.5714286,,0,1\n");
    text = read_back("per-sequence.csv");
    has(text, "\nA,");
    has(text, ",0.5714286,20,50,3\nB,");
}
END_TEST

/* Without a finite answer there is no mean, and what has nothing to average stays empty. */
START_TEST(failures)
{
    eval_breakdown *b = eval_breakdown_new(arena);
    double joints[3 * LT_HAND_KEYPOINTS] = { NAN };
    const eval_breakdown_sample s = { .name = "0001", .joints = joints, .truth = truth };

    ck_assert_int_eq(eval_breakdown_add(b, &s), LT_OK);
    ck_assert_int_eq(eval_breakdown_write(b, scratch_folder), LT_OK);
    has(read_back("per-joint.csv"), "wrist,,\n");
    ck_assert_str_eq(read_back("per-object.csv"), "object,pa_mpjpe_mm,mpjpe_mm,add_mm,add01_percent,samples\n");
    has(read_back("per-sequence.csv"), "\n0001,,,,,1\n");
    ck_assert_int_ne(eval_breakdown_write(b, "no/such/folder"), LT_OK);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, start, stop);
    tcase_add_test(t, groups);
    tcase_add_test(t, failures);
}

int main(void)
{
    return run_suite("breakdown", add_tests);
}
