/* SPDX-License-Identifier: Apache-2.0 */
/* JSON: places in errors, limits, numbers in any locale, names that were meant. */
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/json_object.h"
#include "tests/io/hostile.h"

#include <cjson/cJSON.h>
#include <locale.h>
#include <math.h>

static lt_status read_json(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    cJSON *value;
    lt_status st = lt_json_parse("x.json", (const char *)bytes, n, &value);

    (void)arena;
    if (!st)
        cJSON_Delete(value);
    return st;
}

/* A million numbers of one digit would take 80 MB; as many of six digits are what a file may hold. */
START_TEST(many_values)
{
    const size_t n = 1000000;
    char *text = malloc(8 * n);
    cJSON *root;

    text[0] = '[';
    for (size_t i = 0; i < n; i++)
        memcpy(text + 1 + 2 * i, i + 1 < n ? "1," : "1]", 2);
    check_error(lt_json_parse("many", text, 1 + 2 * n, &root), LT_EFORMAT, "more values than a file of its size");
    for (size_t i = 0; i < n; i++)
        memcpy(text + 1 + 8 * i, i + 1 < n ? "1.23456," : "1.23456]", i + 1 < n ? 8 : 7);
    text[8 * n - 1] = ']';
    check_ok(lt_json_parse("many", text, 8 * n, &root));
    cJSON_Delete(root);
    free(text);
}
END_TEST

START_TEST(errors_have_places)
{
    static const struct {
        const char *text, *reason;
    } cases[] = {
        { "{\n  \"lr\": 1e-3,\n  \"steps\": oops\n}", "x.json:3:12: not valid JSON" },
        { "{} {}", "x.json:1:4: text after" }, { "", "empty" }, { "\xef\xbb\xbf", "empty" },
        { "{\"a\": \"b\\u0000c\"}", "x.json:1:7: string with \\u0000" },
        { "[1, 2", "not valid JSON" }, { "\"abc", "not valid JSON" },
    };
    char deep[2000];

    for (size_t i = 0; i < LT_COUNT(cases); i++)
        check_refused(read_json, cases[i].text, strlen(cases[i].text), cases[i].reason);
    memset(deep, '[', sizeof(deep));
    check_refused(read_json, deep, sizeof(deep), "x.json:1:65: nested deeper than 64");
    check_ok(attempt(read_json, (const uint8_t *)"\xef\xbb\xbf{\"a\\\\\": \"]\\\"\"} \n", 19));
}
END_TEST

START_TEST(damage)
{
    static const char text[] = "{\"name\": \"r\\u00e9s\", \"list\": [1, -2.5e3, true, null], \"in\": {\"x\": {}}}";

    check_truncated(read_json, (const uint8_t *)text, sizeof(text) - 1, 0);
    check_flipped(read_json, (const uint8_t *)text, sizeof(text) - 1, 10000);
}
END_TEST

START_TEST(numbers)
{
    static const struct {
        double x;
        const char *text;
    } cases[] = {
        { 0.1, "0.1" }, { 1, "1" }, { -2.5, "-2.5" }, { 1e300, "1e+300" }, { NAN, "null" }, { INFINITY, "null" },
        { 3e-4, "0.0003" }, { 1.0 / 3, "0.3333333333333333" },
    };
    char out[LT_JSON_NUMBER];
    lt_rng rng = lt_rng_make(1, 1);

    setlocale(LC_ALL, "de_DE.UTF-8");           /* where there is none, nothing is lost */
    for (size_t i = 0; i < LT_COUNT(cases); i++)
        ck_assert_str_eq(lt_json_number(cases[i].x, out), cases[i].text);
    for (int i = 0; i < 10000; i++) {
        const double x = lt_rng_normal(&rng) * pow(10, lt_rng_range(&rng, -300, 300));
        const char *text = lt_json_number(x, out);

        ck_assert_ptr_null(strchr(text, ','));
        setlocale(LC_ALL, "C");
        ck_assert(strtod(text, NULL) == x);
        setlocale(LC_ALL, "de_DE.UTF-8");
    }
    setlocale(LC_ALL, "C");
}
END_TEST

/* As Python writes them; as anything else they are refused. */
START_TEST(words_for_numbers)
{
    static const char text[] = "{\"NaN\": [1, NaN, \"NaN, -Infinity\", -2,-Infinity,Infinity, NaN], \"b\": -0.5}";
    static const char *const bad[] = { "[nan]", "[NaNs]", "[-NaN]", "[Inf]", "{NaN: 1}", "[1 NaN]", "[Infinity" };
    const cJSON *a;
    cJSON *value;

    check_ok(lt_json_parse("x.json", text, strlen(text), &value));
    a = cJSON_GetObjectItemCaseSensitive(value, "NaN");
    ck_assert_int_eq(cJSON_GetArraySize(a), 7);
    ck_assert(cJSON_GetArrayItem(a, 0)->valuedouble == 1 && cJSON_GetArrayItem(a, 3)->valuedouble == -2);
    ck_assert(isnan(cJSON_GetArrayItem(a, 1)->valuedouble) && isnan(cJSON_GetArrayItem(a, 6)->valuedouble));
    ck_assert_str_eq(cJSON_GetArrayItem(a, 2)->valuestring, "NaN, -Infinity");
    ck_assert(cJSON_GetArrayItem(a, 4)->valuedouble == -INFINITY);
    ck_assert(cJSON_GetArrayItem(a, 5)->valuedouble == INFINITY);
    ck_assert(cJSON_GetObjectItemCaseSensitive(value, "b")->valuedouble == -0.5);
    cJSON_Delete(value);
    for (size_t i = 0; i < LT_COUNT(bad); i++)
        check_refused(read_json, bad[i], strlen(bad[i]), "not valid JSON");
    check_refused(read_json, "[NaN,\n oops]", 12, "x.json:2:2: not valid JSON");
    check_truncated(read_json, (const uint8_t *)text, sizeof(text) - 1, 0);
}
END_TEST

START_TEST(round_trip)
{
    static const char text[] = "{\"a\": \"q\\\"\\\\\\n\\u0001\\u00e9\", "
                               "\"b\": [1, 2.5, [true, false, null]], \"c\": {}, \"d\": []}";
    cJSON *value, *back;

    check_ok(lt_json_parse("t", text, sizeof(text) - 1, &value));
    check_ok(lt_json_write(in_folder("r.json"), value));
    check_ok(lt_json_read(in_folder("r.json"), &back));
    ck_assert(cJSON_Compare(value, back, true));
    cJSON_Delete(value);
    cJSON_Delete(back);
}
END_TEST

/* ---- members of an object, one at a time ---- */

static lt_status read_members(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_json_object o;
    lt_json_member m;
    bool more = false;
    lt_status st = lt_json_object_open("x.json", (const char *)bytes, n, &o);

    while (!st && !(st = lt_json_object_next(&o, arena, &m, &more)) && more)
        st = read_json(arena, (const uint8_t *)m.value, m.n);
    return st;
}

#define MEMBERS "\xef\xbb\xbf {\"a\": [1, {\"]\": \"}\\\"\"}] , \"b\\/c\" :\ttrue,\"\":-1e3,\n\"s\": \"{\"}\n "

START_TEST(members)
{
    static const struct { const char *key, *value; } want[] = {
        { "a", "[1, {\"]\": \"}\\\"\"}]" }, { "b/c", "true" }, { "", "-1e3" }, { "s", "\"{\"" },
    };
    lt_arena *arena = lt_arena_new();
    lt_json_object o;
    lt_json_member m;
    bool more;

    check_ok(lt_json_object_open("x.json", MEMBERS, sizeof(MEMBERS) - 1, &o));
    for (size_t i = 0; i < LT_COUNT(want); i++) {
        check_ok(lt_json_object_next(&o, arena, &m, &more));
        ck_assert(more);
        ck_assert_str_eq(m.key, want[i].key);
        ck_assert_int_eq(m.n, strlen(want[i].value));
        ck_assert_mem_eq(m.value, want[i].value, m.n);
    }
    check_ok(lt_json_object_next(&o, arena, &m, &more));
    ck_assert(!more);
    check_ok(lt_json_object_open("x.json", "{}", 2, &o));
    check_ok(lt_json_object_next(&o, arena, &m, &more));
    ck_assert(!more);
    lt_arena_free(arena);
}
END_TEST

static lt_status read_items(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_json_object o;
    lt_json_member m;
    bool more = false;
    lt_status st = lt_json_list_open("x.json", (const char *)bytes, n, &o);

    while (!st && !(st = lt_json_list_next(&o, &m, &more)) && more)
        st = read_json(arena, (const uint8_t *)m.value, m.n);
    return st;
}

#define ITEMS " [{\"a\": [1, 2]} , \"],\", -1e3,\n[]\t] "

START_TEST(items)
{
    static const char *const want[] = { "{\"a\": [1, 2]}", "\"],\"", "-1e3", "[]" };
    static const struct { const char *text, *reason; } cases[] = {
        { "", "ends early, want [" }, { "{}", "x.json:1: byte 0 is 0x7b, want [" }, { "[1 2]", "want a comma or ]" },
        { "[1,]", "want a value" }, { "[1", "ends early, want a comma or ]" }, { "[[1", "ends early, want a value" },
        { "[1] 2", "want the end of the file" }, { "[[1}]", "not valid JSON" },
    };
    lt_arena *arena = lt_arena_new();
    lt_json_object o;
    lt_json_member m;
    bool more;

    check_ok(lt_json_list_open("x.json", ITEMS, sizeof(ITEMS) - 1, &o));
    for (size_t i = 0; i < LT_COUNT(want); i++) {
        check_ok(lt_json_list_next(&o, &m, &more));
        ck_assert(more && !m.key);
        ck_assert_int_eq(m.n, strlen(want[i]));
        ck_assert_mem_eq(m.value, want[i], m.n);
    }
    check_ok(lt_json_list_next(&o, &m, &more));
    ck_assert(!more);
    check_ok(read_items(arena, (const uint8_t *)"[]", 2));
    for (size_t i = 0; i < LT_COUNT(cases); i++)
        check_refused(read_items, cases[i].text, strlen(cases[i].text), cases[i].reason);
    lt_arena_free(arena);
}
END_TEST

START_TEST(members_are_broken)
{
    static const struct { const char *text, *reason; } cases[] = {
        { "", "ends early, want {" }, { "[1]", "x.json:1: byte 0 is 0x5b, want {" },
        { "{\"a\": 1,\n \"b\" 2}", "x.json:2: byte 14 is 0x32, want a colon" },
        { "{\"a\": 1 2}", "want a comma or }" }, { "{\"a\": 1,}", "want a key in quotes" },
        { "{\"a\": }", "want a value" }, { "{\"a\": [1", "ends early, want a value" },
        { "{\"a\": 1} 2", "want the end of the file" }, { "{a: 1}", "want a key in quotes" },
        { "{\"a\": [1}}", "not valid JSON" }, { "{\"a\": 1", "ends early, want a comma or }" },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++)
        check_refused(read_members, cases[i].text, strlen(cases[i].text), cases[i].reason);
    for (size_t n = 0; n + 2 < sizeof(MEMBERS) - 1; n++)
        ck_assert_int_ne(attempt(read_members, (const uint8_t *)MEMBERS, n), LT_OK);
    check_ok(attempt(read_members, (const uint8_t *)MEMBERS, sizeof(MEMBERS) - 1));
}
END_TEST

START_TEST(strings_are_escaped)
{
    char *out = NULL;
    size_t n;
    FILE *f = open_memstream(&out, &n);

    lt_json_print_string(f, "a\"b\\\t\x01\xff\xc3\xa9\x7f");
    fclose(f);
    ck_assert_str_eq(out, "\"a\\\"b\\\\\\t\\u0001\xef\xbf\xbd\xc3\xa9\\u007f\"");
    free(out);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, errors_have_places);
    tcase_add_test(tc, many_values);
    tcase_add_test(tc, damage);
    tcase_add_test(tc, numbers);
    tcase_add_test(tc, words_for_numbers);
    tcase_add_test(tc, round_trip);
    tcase_add_test(tc, strings_are_escaped);
    tcase_add_test(tc, members);
    tcase_add_test(tc, items);
    tcase_add_test(tc, members_are_broken);
}

int main(void)
{
    return run_suite("json", add_tests);
}
