/* SPDX-License-Identifier: Apache-2.0 */
/* The models that come with palmar: their cards. */
#include "estimate/starter.h"

#include "libtensor/io/file.h"
#include "tests/suite.h"

#include <cjson/cJSON.h>
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
    lt_arena_free(arena);
    remove_scratch_folder();
}

static void put(const char *name, const char *text)
{
    FILE *f = fopen(lt_path_join(arena, scratch_folder, name), "w");

    ck_assert_ptr_nonnull(f);
    fputs(text, f);
    fclose(f);
}

#define CARD(name, role) "{ \"name\": \"" name "\", \"role\": \"" role "\", \"licence\": \"Apache-2.0\" }"

START_TEST(cards)
{
    cJSON *list;
    const char *path;

    put("b.json", CARD("b", "hand-object"));
    put("a.json", CARD("a", "detector"));
    put("a.safetensors", "12345");
    put("b.safetensors", "123");
    check_ok(starter_cards(arena, scratch_folder, &list));
    ck_assert_int_eq(cJSON_GetArraySize(list), 2);
    ck_assert_str_eq(cJSON_GetObjectItem(cJSON_GetArrayItem(list, 0), "name")->valuestring, "a");
    ck_assert_double_eq(cJSON_GetObjectItem(cJSON_GetArrayItem(list, 0), "bytes")->valuedouble, 5);
    cJSON_Delete(list);
    check_ok(starter_find(arena, scratch_folder, STARTER_COLOUR, &path));
    ck_assert_str_eq(path, lt_path_join(arena, scratch_folder, "b.safetensors"));
    ck_assert_int_eq(starter_find(arena, scratch_folder, STARTER_DEPTH, &path), LT_EIO);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "(none of role \"hand-object-depth\")"));
}
END_TEST

START_TEST(bad_folders)
{
    cJSON *list;

    ck_assert_int_eq(starter_cards(arena, lt_path_join(arena, scratch_folder, "none"), &list), LT_EIO);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "has no starter models; scripts/train-starter trains them"));
    put("a.json", "{ \"name\": 3 }");
    ck_assert_int_eq(starter_cards(arena, scratch_folder, &list), LT_EFORMAT);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "a.json: is no card of a model: \"name\" is no text"));
    put("a.json", "{ \"name");
    ck_assert_int_eq(starter_cards(arena, scratch_folder, &list), LT_EFORMAT);
    put("a.json", CARD("a", "detector"));
    ck_assert_int_eq(starter_cards(arena, scratch_folder, &list), LT_EFORMAT);
    ck_assert_ptr_nonnull(strstr(lt_last_error(), "its weights are not beside it, expected "));
}
END_TEST

START_TEST(folder)
{
    unsetenv("PALMAR_STARTER");
    ck_assert_str_eq(starter_folder(arena, "/somewhere"), "/somewhere/models/starter");
    setenv("PALMAR_STARTER", "/else", 1);
    ck_assert_str_eq(starter_folder(arena, "/somewhere"), "/else");
    unsetenv("PALMAR_STARTER");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, cards);
    tcase_add_test(tc, bad_folders);
    tcase_add_test(tc, folder);
}

int main(void)
{
    return run_suite("starter", add_tests);
}
