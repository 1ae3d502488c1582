/* SPDX-License-Identifier: Apache-2.0 */
/* Structs from JSON by a table of keys: what each type takes, what it says of the rest, overrides, no memory. */
#include "libtensor/io/text/config.h"
#include "tests/io/hostile.h"

#include <cjson/cJSON.h>
#include <stddef.h>

typedef struct {
    int count, kind, any;
    double rate;
    bool on;
    const char *name;
    int box[4];
} settings;

static const char *const kinds[] = { "sgd", "adam", NULL };

#define KEY(field) .name = #field, .offset = offsetof(settings, field)
static const lt_config_key keys[] = {
    { KEY(count), .type = LT_CONFIG_INT, .fallback = "3", .lo = 1, .hi = 9 },
    { KEY(any), .type = LT_CONFIG_INT, .fallback = "-70000" },
    { KEY(rate), .type = LT_CONFIG_NUMBER, .fallback = "-0.5", .lo = -1, .hi = 0 },
    { KEY(on), .type = LT_CONFIG_BOOL, .fallback = "true" },
    { KEY(name), .type = LT_CONFIG_TEXT, .fallback = "\"nobody\"" },
    { KEY(kind), .type = LT_CONFIG_CHOICE, .fallback = "\"adam\"", .choices = kinds },
    { KEY(box), .type = LT_CONFIG_INTS, .fallback = "[1, 2, 3, 4]" },
    { .name = NULL },
};

static lt_arena *arena;

static void setup(void) { arena = lt_arena_new(); }
static void teardown(void) { lt_arena_free(arena); }

static lt_status read_text(const char *text, settings *out)
{
    cJSON *object = cJSON_Parse(text);
    const lt_status st = lt_config_read(arena, "f.json", object, keys, out);

    ck_assert_msg(object, "%s", text);
    cJSON_Delete(object);
    return st;
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

START_TEST(what_is_missing_is_the_default)
{
    settings s;

    check_ok(lt_config_read(arena, "f.json", NULL, keys, &s));
    ck_assert(s.count == 3 && s.any == -70000 && s.rate == -0.5 && s.on && s.kind == 1 && s.box[3] == 4);
    check_ok(read_text("{\"count\": 4}", &s));
    ck_assert(s.count == 4 && s.any == -70000);
    ck_assert_str_eq(s.name, "nobody");
}
END_TEST

START_TEST(each_type_is_read)
{
    settings s;

    check_ok(read_text("{\"count\": 9, \"rate\": -0.25, \"on\": false, \"name\": \"\xc3\xa9\", \"kind\": \"sgd\","
                       "\"box\": [0, -1, 2147483647, 5], \"any\": 2147483647}", &s));
    ck_assert_int_eq(s.count, 9);
    ck_assert_int_eq(s.any, 2147483647);
    ck_assert_double_eq(s.rate, -0.25);
    ck_assert(!s.on);
    ck_assert_str_eq(s.name, "\xc3\xa9");
    ck_assert_int_eq(s.kind, 0);
    ck_assert_int_eq(s.box[2], 2147483647);
}
END_TEST

static const struct {
    const char *text, *line;
} slips[] = {
    { "[]", "f.json: want an object of keys" },
    { "{\"cuont\": 1}", "f.json.cuont: no such key; did you mean \"count\"?" },
    { "{\"zzzzzzzzz\": 1}", "f.json.zzzzzzzzz: no such key; there are: count, any, rate, on, name, kind, box" },
    { "{\"count\": \"1\"}", "f.json.count: found \"1\", want a number" },
    { "{\"count\": 1e999}", "f.json.count: found null, want a number" },
    { "{\"count\": 1.5}", "f.json.count: found 1.5, want a whole number" },
    { "{\"any\": 2147483648}", "f.json.any: found 2147483648, want a whole number from -2147483647 to 2147483647" },
    { "{\"any\": -2147483648}", "f.json.any: found -2147483648, want a whole number from -2147483647 to 2147483647" },
    { "{\"count\": 0}", "f.json.count: 0 is not between 1 and 9" },
    { "{\"count\": 10}", "f.json.count: 10 is not between 1 and 9" },
    { "{\"rate\": 0.5}", "f.json.rate: 0.5 is not between -1 and 0" },
    { "{\"on\": 1}", "f.json.on: found 1, want true or false" },
    { "{\"name\": null}", "f.json.name: found null, want text" },
    { "{\"kind\": 1}", "f.json.kind: found 1, want text" },
    { "{\"kind\": \"adan\"}", "f.json.kind: no such choice \"adan\"; did you mean \"adam\"?" },
    { "{\"kind\": \"zzzzzzzzz\"}", "f.json.kind: no such choice \"zzzzzzzzz\"; did you mean \"sgd\"?" },
    { "{\"box\": [1, 2, 3]}", "f.json.box: found [1,2,3], want a list of four whole numbers" },
    { "{\"box\": {\"a\": 1, \"b\": 2, \"c\": 3, \"d\": 4}}",
      "f.json.box: found {\"a\":1,\"b\":2,\"c\":3,\"d\":4}, want a list of four whole numbers" },
    { "{\"box\": [1, 2, 3, 4.5]}", "f.json.box: found 4.5, want a whole number" },
};

START_TEST(slips_are_named)
{
    settings s;

    ck_assert_int_eq(read_text(slips[_i].text, &s), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), slips[_i].line);
}
END_TEST

/* ---- writing, and overrides ------------------------------------------------------------------------------------ */

static const settings sample = {
    .count = 7, .any = -1, .rate = -0.5, .on = true, .name = "n", .kind = 1, .box = { 4, 3, 2, 1 },
};

START_TEST(what_is_written_is_read)
{
    cJSON *object = lt_config_write(keys, &sample);
    settings back;

    check_ok(lt_config_read(arena, "f.json", object, keys, &back));
    ck_assert(back.count == 7 && back.any == -1 && back.rate == -0.5 && back.on && back.kind == 1 && back.box[3] == 1);
    ck_assert_str_eq(back.name, "n");
    cJSON_Delete(object);
}
END_TEST

START_TEST(an_override_is_blamed_for_its_own_keys)
{
    static const char *const set[] = { "optim.lr=x", "data.dir=/there", "seed=3" };
    static const struct {
        const char *path, *line, *want;
    } cases[] = {
        { "a.json", "a.json: optim.lr: found \"x\"", "--set optim.lr: found \"x\"" },
        { "a.json", "a.json: data: no such group", "--set data: no such group" },
        { "", "seed: 3 is too many", "--set seed: 3 is too many" },
        { "a.json", "a.json: optim.lrr: no such key", NULL },
        { "a.json", "a.json: optim.l: no such key", NULL },
        { "a.json", "b.json: optim.lr: found \"x\"", NULL },
        { "a.json", "no memory", NULL },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        const lt_status st = lt_error(LT_EINVAL, "%s", cases[i].line);

        ck_assert_int_eq(lt_config_blame(cases[i].path, "--set", set, 3, st), cases[i].want ? LT_EUSAGE : LT_EINVAL);
        ck_assert_str_eq(lt_last_error(), cases[i].want ? cases[i].want : cases[i].line);
    }
    ck_assert_int_eq(lt_config_blame("", "--set", NULL, 0, lt_error(LT_EIO, "seed: 3")), LT_EIO);
}
END_TEST

/* Applied in turn to one tree */
static const struct {
    const char *set, *want;             /* the tree as text, or the line of a refusal */
} overrides[] = {
    { "a.b.c=1", "{\"a\":{\"b\":{\"c\":1}}}" },
    { "a.b.c=[1, 2]", "{\"a\":{\"b\":{\"c\":[1,2]}}}" },
    { "a.b.c=some words", "{\"a\":{\"b\":{\"c\":\"some words\"}}}" },
    { "a.b.d=", "{\"a\":{\"b\":{\"c\":\"some words\",\"d\":\"\"}}}" },
    { "a.b=1=2", "{\"a\":{\"b\":\"1=2\"}}" },
    { "a.b.c=1", "--set a.b.c=1: b is no group of keys" },
    { "a", "--set a: want key=value, as in optim.lr=3e-4" },
    { "=1", "--set =1: want key=value, as in optim.lr=3e-4" },
};

START_TEST(overrides_are_put_into_the_tree)
{
    cJSON *root = cJSON_CreateObject();
    char longer[300];

    for (size_t i = 0; i < LT_COUNT(overrides); i++) {
        const lt_status st = lt_config_set(root, "--set", overrides[i].set);
        char *text = cJSON_PrintUnformatted(root);

        ck_assert(st == LT_OK || st == LT_EUSAGE);
        ck_assert_str_eq(st ? lt_last_error() : text, overrides[i].want);
        cJSON_free(text);
    }
    memset(longer, 'k', sizeof(longer));
    memcpy(longer + 256, "=1", 3);
    check_error(lt_config_set(root, "--set", longer), LT_EUSAGE, "want key=value");
    cJSON_Delete(root);
}
END_TEST

/* ---- without memory -------------------------------------------------------------------------------------------- */

static long countdown, alive;

static void *failing_malloc(size_t n)
{
    if (countdown > 0 && --countdown == 0)
        return NULL;
    alive++;
    return malloc(n);
}

static void counting_free(void *p)
{
    alive -= p != NULL;
    free(p);
}

static void fail_cjson_at(long n)
{
    countdown = n;
    cJSON_InitHooks(n ? &(cJSON_Hooks){ failing_malloc, counting_free } : NULL);
}

START_TEST(reading_without_memory_says_so)
{
    lt_status st = LT_ENOMEM;

    for (long at = 1; st; at++) {
        settings s;

        fail_cjson_at(at);
        st = lt_config_read(arena, "f.json", NULL, &keys[3], &s);
        fail_cjson_at(0);
        ck_assert_msg(st == LT_OK || st == LT_ENOMEM, "%ld: %s", at, lt_last_error());
        ck_assert_int_eq(alive, 0);
    }
    for (int room = 0; room < 2; room++) {
        lt_arena *small = arena_with_room(room);
        settings s;

        lt_alloc_fail_at(1);
        ck_assert_int_eq(lt_config_read(small, "f.json", NULL, &keys[3], &s), room ? LT_OK : LT_ENOMEM);
        lt_alloc_fail_at(0);
        lt_arena_free(small);
    }
}
END_TEST

/* The value that was found cannot be printed; the rest of the line stands. */
START_TEST(a_slip_is_named_without_memory)
{
    cJSON *object = cJSON_Parse("{\"on\": 1}");
    settings s;

    fail_cjson_at(1);
    check_error(lt_config_read(arena, "f.json", object, &keys[3], &s), LT_EINVAL,
                "f.json.on: found ?, want true or false");
    fail_cjson_at(0);
    cJSON_Delete(object);
}
END_TEST

START_TEST(writing_without_memory_leaves_nothing)
{
    cJSON *object = NULL;

    for (long at = 1; !object; at++) {
        fail_cjson_at(at);
        object = lt_config_write(keys, &sample);
        countdown = 0;
        ck_assert_msg(object || alive == 0, "allocation %ld: %ld left", at, alive);
        ck_assert_int_lt(at, 100);
    }
    cJSON_Delete(object);
    fail_cjson_at(0);
}
END_TEST

START_TEST(overriding_without_memory_says_so)
{
    lt_status st = LT_ENOMEM;

    for (long at = 1; st; at++) {
        cJSON *root;

        fail_cjson_at(at + 1);
        root = cJSON_CreateObject();
        st = lt_config_set(root, "--set", "a.b=words");
        countdown = 0;
        ck_assert_msg(st == LT_OK || st == LT_ENOMEM, "allocation %ld: %s", at, lt_last_error());
        cJSON_Delete(root);
        ck_assert_msg(alive == 0, "allocation %ld: %ld left", at, alive);
        fail_cjson_at(0);
    }
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, what_is_missing_is_the_default);
    tcase_add_test(tc, each_type_is_read);
    tcase_add_loop_test(tc, slips_are_named, 0, LT_COUNT(slips));
    tcase_add_test(tc, what_is_written_is_read);
    tcase_add_test(tc, overrides_are_put_into_the_tree);
    tcase_add_test(tc, an_override_is_blamed_for_its_own_keys);
    tcase_add_test(tc, reading_without_memory_says_so);
    tcase_add_test(tc, a_slip_is_named_without_memory);
    tcase_add_test(tc, writing_without_memory_leaves_nothing);
    tcase_add_test(tc, overriding_without_memory_says_so);
}

int main(void)
{
    return run_suite("config", add_tests);
}
