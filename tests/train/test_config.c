/* SPDX-License-Identifier: Apache-2.0 */
/* The configuration of a run: overrides, slips of the pen, and that what is written reads back. */
#include "libtensor/io/text/json.h"
#include "tasks/hand_object/config.h"
#include "tasks/tasks.h"
#include "tests/suite.h"
#include "train/config.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

static lt_arena *arena;

static void setup(void) { arena = lt_arena_new(); }
static void teardown(void) { lt_arena_free(arena); }

static void refuse(const char *text, const char *set, const char *line)
{
    const char *const sets[] = { set };
    train_config c;
    const lt_status st = train_config_parse(arena, tasks, "run.json", text, sets, set != NULL, &c);

    ck_assert_int_ne(st, LT_OK);
    ck_assert_str_eq(lt_last_error(), line);
    ck_assert_int_eq(st == LT_EUSAGE, strncmp(line, "--set ", 6) == 0);
}

#define MODEL "\"model\": { \"name\": \"hocat\" }"

START_TEST(defaults_are_the_papers)
{
    train_config c;

    ck_assert_int_eq(train_config_parse(arena, tasks, "run.json", "{" MODEL "}", NULL, 0, &c), LT_OK);
    ck_assert_str_eq(c.model->name, "hocat");
    ck_assert_int_eq(c.optim.batch, 32);
    ck_assert_int_eq(c.optim.epochs, 120);
    ck_assert_double_eq(c.optim.lr, 1e-4);
    ck_assert_double_eq(c.optim.gamma, 0.7);
    ck_assert_double_eq(c.optim.weight_decay, 5e-4);
    ck_assert_double_eq(hand_object_config_of(&c)->background, 0);
    ck_assert_int_eq(c.loop.max_bad_steps, 5);
    train_config_fini(&c);
}
END_TEST

START_TEST(overrides)
{
    const char *const sets[] = { "optim.lr=3e-4", "data.dir=/some where", "model.width=16", "optim.shards=4" };
    train_config c;

    ck_assert_int_eq(train_config_parse(arena, tasks, "run.json", "{" MODEL ", \"optim\": { \"lr\": 1 } }", sets, 4,
                                        &c),
                     LT_OK);
    ck_assert_double_eq(c.optim.lr, 3e-4);
    ck_assert_str_eq(c.data->dir, "/some where");
    ck_assert_int_eq(c.optim.shards, 4);
    ck_assert_int_eq(cJSON_GetObjectItem(c.model_keys, "width")->valueint, 16);
    ck_assert_ptr_null(cJSON_GetObjectItem(c.model_keys, "name"));
    train_config_fini(&c);
}
END_TEST

/* The model reads its own keys, when it is made. */
START_TEST(slips_in_the_models_keys)
{
    const char *const sets[] = { "model.width=-3" };
    lt_params *params = lt_params_new();
    train_config c;
    model m;

    check_ok(train_config_parse(arena, tasks, "run.json", "{" MODEL "}", sets, 1, &c));
    check_error(train_config_model(&c, NULL, params, &m), LT_EUSAGE, "--set model.width: -3 is not between 8 and 256");
    train_config_fini(&c);
    check_ok(train_config_parse(arena, tasks, "run.json", "{ \"model\": { \"name\": \"hocat\", \"width\": -3 } }", NULL,
                                0, &c));
    check_error(train_config_model(&c, NULL, params, &m), LT_EINVAL, "run.json: model.width: -3 is not between");
    train_config_fini(&c);
    lt_params_free(params);
}
END_TEST

START_TEST(slips)
{
    refuse("{" MODEL "}", "optim.lrr=1", "--set optim.lrr: no such key; did you mean \"lr\"?");
    refuse("{" MODEL ", \"optm\": {} }", NULL, "run.json: optm: no such group; did you mean \"optim\"?");
    refuse("{" MODEL ", \"zzzzzzz\": {} }", NULL,
           "run.json: zzzzzzz: no such group; there are model, data, optim, train");
    refuse("{" MODEL "}", "optm.lr=1", "--set optm: no such group; did you mean \"optim\"?");
    refuse("{}", NULL, "run.json: model.name: want the name of a model, such as \"hocat\"");
    refuse("{" MODEL "}", "model.name=resnet50", "--set model.name: resnet50 is a classifier: palmar bench and "
           "info know it, but there is no data to train it on");
    refuse("{" MODEL "}", "model.name=hokat", "--set model.name: no such model \"hokat\"; did you mean \"hocat\"?");
    refuse("{" MODEL "}", "optim.shards=5", "--set optim.shards: 5 do not divide a batch of 32");
    refuse("{" MODEL "}", "optim.kind=adan", "--set optim.kind: no such choice \"adan\"; did you mean \"adam\"?");
    refuse("{" MODEL "}", "train.seed=-1", "--set train.seed: -1 is not between 0 and 2147483647");
    refuse("{" MODEL "}", "data.background=1.5", "--set data.background: 1.5 is not between 0 and 1");
    refuse("{" MODEL "}", "optim.kind=ADAM", "--set optim.kind: no such choice \"ADAM\"; did you mean \"adam\"?");
    refuse("{" MODEL "}", "train.seed=99999999999",
           "--set train.seed: found 99999999999, want a whole number from -2147483647 to 2147483647");
    refuse("{" MODEL ", \"optim\": { \"lr\": 1, \"lr\": 2 } }", NULL, "run.json: optim.lr: is there twice");
    refuse("{" MODEL ", \"optim\": {}, \"optim\": {} }", NULL, "run.json: optim: is there twice");
    refuse("[]", NULL, "run.json: want an object with the groups model, data, optim, train");
}
END_TEST

START_TEST(help_names_every_key)
{
    char *text = NULL;
    size_t n;
    FILE *f = open_memstream(&text, &n);

    train_config_help(tasks, f);
    fclose(f);
    ck_assert_ptr_nonnull(strstr(text, "  optim.lr: number from 0 to 1e+30, default 1e-4\n"));
    ck_assert_ptr_nonnull(strstr(text, "  optim.kind: one of sgd adam adamw muon, default \"adam\"\n"));
    ck_assert_ptr_nonnull(strstr(text, "  model.image_size: "));
    ck_assert_ptr_nonnull(strstr(text, "  train.max_bad_steps: "));
    free(text);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_checked_fixture(c, setup, teardown);
    tcase_add_test(c, defaults_are_the_papers);
    tcase_add_test(c, overrides);
    tcase_add_test(c, slips);
    tcase_add_test(c, slips_in_the_models_keys);
    tcase_add_test(c, help_names_every_key);
}

int main(void)
{
    return run_suite("config", add_tests);
}
