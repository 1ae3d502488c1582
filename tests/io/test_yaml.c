/* SPDX-License-Identifier: Apache-2.0 */
/* The YAML reader: what DexYCB's files hold, as PyYAML writes it, and what no file may ask of us. */
#include "libtensor/io/text/yaml.h"
#include "tests/io/hostile.h"

#include <string.h>

static lt_arena *arena;

static void setup(void)
{
    arena = lt_arena_new();
}

static void teardown(void)
{
    lt_arena_free(arena);
}

static const lt_yaml *parse(const char *text)
{
    const lt_yaml *v = NULL;

    check_ok(lt_yaml_parse(arena, "t.yml", (const uint8_t *)text, strlen(text), &v));
    return v;
}

static void refused(const char *text, const char *reason)
{
    const lt_yaml *v = NULL;

    ck_assert_int_eq(lt_yaml_parse(arena, "t.yml", (const uint8_t *)text, strlen(text), &v), LT_EFORMAT);
    ck_assert_msg(strstr(lt_last_error(), reason), "\"%s\" lacks \"%s\"", lt_last_error(), reason);
    ck_assert_ptr_null(v);
}

static const lt_yaml *get(const lt_yaml *v, const char *key)
{
    const lt_yaml *out = NULL;

    check_ok(lt_yaml_get(v, key, &out));
    return out;
}

/* ---- what is read ---- */

static const char meta[] =
    "# of a sequence\n"
    "extrinsics: '20200702_151821'\n"
    "mano_calib:\n"
    "- 20200514-subject-01\n"
    "mano_sides:\n"
    "- right\n"
    "num_frames: 72\n"
    "serials:\n"
    "- '836212060125'\n"
    "- 839512060362\n"
    "ycb_grasp_ind: 2\n"
    "ycb_ids: [2, 8, 15]\n";

START_TEST(reads_meta)
{
    const lt_yaml *v = parse(meta), *list;
    const char *text;
    double ids[3];
    int n;

    ck_assert_int_eq(v->kind, LT_YAML_MAP);
    ck_assert_int_eq(v->n, 7);
    check_ok(lt_yaml_text(get(v, "extrinsics"), &text));
    ck_assert_str_eq(text, "20200702_151821");
    check_ok(lt_yaml_int(get(v, "num_frames"), 1, 10000, &n));
    ck_assert_int_eq(n, 72);
    list = get(v, "serials");
    check_ok(lt_yaml_list(list, 2));
    ck_assert_str_eq(list->first->text, "836212060125");
    ck_assert_str_eq(list->first->next->text, "839512060362");
    ck_assert_int_eq(list->first->line, 9);
    check_ok(lt_yaml_numbers(get(v, "ycb_ids"), ids, 3));
    ck_assert_double_eq(ids[2], 15);
}
END_TEST

/* Python's tuples, block lists of block lists, numbers in every way they are written. */
START_TEST(reads_extrinsics)
{
    const lt_yaml *v = parse("--- \n"
                             "extrinsics:\n"
                             "  '840412060917': !!python/tuple\n"
                             "  - 1.0\n"
                             "  - 0\n"
                             "  - -5.0e-05\n"
                             "  - !!float '1e3'\n"
                             "  apriltag: [+1, .5,\n"
                             "    2., -0]\n"
                             "master: \"840412060917\"\n");
    const lt_yaml *e = get(v, "extrinsics");
    double x[4];

    check_ok(lt_yaml_numbers(get(e, "840412060917"), x, 4));
    ck_assert_double_eq(x[2], -5e-5);
    ck_assert_double_eq(x[3], 1000);
    check_ok(lt_yaml_numbers(get(e, "apriltag"), x, 4));
    ck_assert_double_eq(x[1], .5);
    ck_assert_str_eq(get(v, "master")->text, "840412060917");
}
END_TEST

/* OpenCV's first line is no YAML, and its tag says what the map says; lines are counted all the same. */
START_TEST(reads_what_opencv_writes)
{
    const lt_yaml *v = parse("%YAML:1.0\r\n---\nK: !!opencv-matrix\n   rows: 1\n   data: [ 6.06e+02, 0. ]\n");
    double x[2];

    check_ok(lt_yaml_numbers(get(get(v, "K"), "data"), x, 2));
    ck_assert(x[0] == 606 && x[1] == 0);
    ck_assert_int_eq(get(v, "K")->first->line, 4);
}
END_TEST

START_TEST(reads_a_scalar_alone)
{
    double x;

    check_ok(lt_yaml_numbers(parse("3.5\n"), &x, 1));
    ck_assert_double_eq(x, 3.5);
}
END_TEST

/* ---- values that are not what was asked for ---- */

/* No %TAG lines, though they say so; and the mark that Windows' editors write */
START_TEST(reads_texts_with_percents)
{
    const char *text;

    check_ok(lt_yaml_text(get(parse("\xef\xbb\xbf# 100%TAG\na: x%TAG\nb: 'x\n %TAG'\n"), "b"), &text));
    ck_assert_str_eq(text, "x %TAG");
}
END_TEST

START_TEST(says_what_was_found)
{
    const lt_yaml *v = parse("a: [1, x]\nb: 2.5\nc: {d: .nan}\n"), *out = NULL;
    const char *text;
    double x[3];
    int n;

    check_error(lt_yaml_get(v, "z", &out), LT_EFORMAT, "t.yml:1: no key \"z\"");
    check_error(lt_yaml_get(get(v, "a"), "z", &out), LT_EFORMAT, "t.yml:1: a: found a list, expected a map");
    check_error(lt_yaml_numbers(get(v, "a"), x, 3), LT_EFORMAT, "t.yml:1: a: found a list of 2, expected 3");
    check_error(lt_yaml_numbers(get(v, "a"), x, 2), LT_EFORMAT, "t.yml:1: found \"x\", expected a number");
    check_error(lt_yaml_int(get(v, "b"), 0, 9, &n), LT_EFORMAT, "t.yml:2: b: found 2.5, expected a whole number from 0 "
                "to 9");
    check_error(lt_yaml_int(get(v, "c"), 0, 9, &n), LT_EFORMAT, "t.yml:3: c: found a map, expected a number");
    check_error(lt_yaml_int(parse("7"), 8, 9, &n), LT_EFORMAT, "t.yml:1: found 7, expected a whole number from 8 to 9");
    check_error(lt_yaml_int(parse("7"), 5, 6, &n), LT_EFORMAT, "t.yml:1: found 7, expected a whole number from 5 to 6");
    check_error(lt_yaml_list(get(v, "c"), -1), LT_EFORMAT, "t.yml:3: c: found a map, expected a list");
    check_error(lt_yaml_list(parse("[1, 2]"), 3), LT_EFORMAT, "t.yml:1: found a list of 2, expected 3");
    check_error(lt_yaml_numbers(get(v, "c"), x, 1), LT_EFORMAT, "t.yml:3: c: found a map, expected a list");
    check_error(lt_yaml_numbers(parse("7x"), x, 1), LT_EFORMAT, "t.yml:1: found \"7x\", expected a number");
    check_error(lt_yaml_numbers(parse("1e999"), x, 1), LT_EFORMAT, "t.yml:1: found \"1e999\", expected a number");
    check_error(lt_yaml_get(parse("7"), "z", &out), LT_EFORMAT, "t.yml:1: found \"7\", expected a map");
    check_error(lt_yaml_text(get(v, "c"), &text), LT_EFORMAT, "t.yml:3: c: found a map, expected a text");
    check_error(lt_yaml_numbers(get(get(v, "c"), "d"), x, 1), LT_EFORMAT,
                "t.yml:3: d: found \".nan\", expected a number");
    ck_assert_ptr_null(out);
}
END_TEST

/* ---- what is not read ---- */

static const struct { const char *text, *reason; } hostile[] = {
    { "", "empty" },
    { "# nothing\n", "empty" },
    { "a: &x [1]\nb: 2\n", "t.yml:1: found an anchor" },
    { "a: *x\n", "t.yml:1: found an alias" },
    { "a: &x [1]\nb: [*x, *x]\n", "anchor" },
    { "<<: {a: 1}\n", "merge key" },
    { "a: 1\n---\nb: 2\n", "t.yml:2: found a second document" },
    { "a: !!python/object/apply:os.system ['true']\n", "found the tag tag:yaml.org,2002:python/object" },
    { "a: !local 3\n", "found the tag !local" },
    { "!!python/name:os.system a\n", "found the tag" },
    { "a: !!binary aGk=\n", "found the tag" },
    { "{[1, 2]: 3}\n", "as a key" },
    { "{{a: 1}: 3}\n", "as a key" },
    { "a: 1\nb: 2\na: 3\n", "t.yml:3: the key a comes twice, first on line 1" },
    { "a: \"x\\0y\"\n", "NUL" },
    { "a: [1, 2\n", "t.yml:2:" },
    { "a: }\n", "t.yml:1:" },
    { "\ta: 1\n", "t.yml:1:" },
    { "a: 'x\n", "t.yml:" },
    { "a: \xff\xfe\n", "byte 3" },
    { "[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]", "nested more than 16 deep" },
    { "%YAML 3.0\n--- a\n", "t.yml:1:" },
    { "# tags\n%TAG !a! !\n%TAG !a! !\n--- a\n", "t.yml:2: found a %TAG line, which is not read" },
    { "%TAG !a! !\n--- a\n", "t.yml:1: found a %TAG" },
    { "\xef\xbb\xbf%TAG !a! !\n--- a\n", "t.yml:1: found a %TAG" },
    { "\n#\r%TAG !a! !\r--- a\n", "t.yml:2: found a %TAG" },
    { "#\xc2\x85%TAG !a! !\n--- a\n", "t.yml:1: found a %TAG" },
    { "\xff\xfe" "a", "t.yml: byte 0" },
};

START_TEST(refuses)
{
    refused(hostile[_i].text, hostile[_i].reason);
}
END_TEST

START_TEST(refuses_too_many_values)
{
    const size_t n = 2 * LT_YAML_NODES + 3;
    char *text = lt_arena_alloc(arena, n + 1);

    text[0] = '[';
    for (size_t i = 1; i < n - 1; i++)
        text[i] = i % 2 ? '1' : ',';
    text[n - 1] = ']';
    refused(text, "more than 16384 values");
}
END_TEST

START_TEST(refuses_too_many_keys)
{
    char *text = lt_arena_alloc(arena, 1 << 16), *p = text;

    for (int i = 0; i < 300; i++)
        p += sprintf(p, "k%d: 1\n", i);
    refused(text, "more than 256 keys");
}
END_TEST

START_TEST(refuses_large_files)
{
    const size_t n = LT_YAML_MAX + 1;
    char *text = lt_arena_alloc(arena, n + 1);

    memset(text, ' ', n);
    refused(text, "at most");
    put_file(in_folder("large.yml"), text, n);
    const lt_yaml *v;
    ck_assert_int_ne(lt_yaml_read(arena, in_folder("large.yml"), &v), LT_OK);
}
END_TEST

START_TEST(names_the_file)
{
    const lt_yaml *v;

    ck_assert_int_eq(lt_yaml_read(arena, in_folder("none.yml"), &v), LT_EIO);
    put_file(in_folder("a.yml"), meta, strlen(meta));
    check_ok(lt_yaml_read(arena, in_folder("a.yml"), &v));
    ck_assert_ptr_nonnull(strstr(v->path, "a.yml"));
}
END_TEST

/* ---- damage ---- */

static lt_status read_bytes(lt_arena *a, const uint8_t *bytes, size_t n)
{
    const lt_yaml *v;

    return lt_yaml_parse(a, "t.yml", bytes, n, &v);
}

/* A cut file may be a whole one: what counts is that nothing crashes and that each refusal says why. */
START_TEST(stands_cuts_and_flips)
{
    for (size_t n = 0; n <= strlen(meta); n++)
        attempt(read_bytes, (const uint8_t *)meta, n);
    check_flipped(read_bytes, (const uint8_t *)meta, strlen(meta), 10000);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, reads_meta);
    tcase_add_test(tc, reads_extrinsics);
    tcase_add_test(tc, reads_what_opencv_writes);
    tcase_add_test(tc, reads_a_scalar_alone);
    tcase_add_test(tc, says_what_was_found);
    tcase_add_test(tc, reads_texts_with_percents);
    tcase_add_loop_test(tc, refuses, 0, LT_COUNT(hostile));
    tcase_add_test(tc, refuses_too_many_values);
    tcase_add_test(tc, refuses_too_many_keys);
    tcase_add_test(tc, refuses_large_files);
    tcase_add_test(tc, names_the_file);
    tcase_add_test(tc, stands_cuts_and_flips);
}

int main(void)
{
    return run_suite("yaml", add_tests);
}
