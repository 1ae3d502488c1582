/* SPDX-License-Identifier: Apache-2.0 */
/* The papers' tables with rows of runs, whose folders are written here. */
#include "eval/tables/filled.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RUNS "test_filled.dir"

static void write_text(const char *run, const char *name, const char *text)
{
    char path[256];
    FILE *f;

    snprintf(path, sizeof(path), RUNS "/%s/eval", run);
    ck_assert_int_eq(lt_make_dirs(path), LT_OK);
    snprintf(path, sizeof(path), RUNS "/%s/%s", run, name);
    f = fopen(path, "w");
    ck_assert_ptr_nonnull(f);
    fputs(text, f);
    fclose(f);
}

typedef struct {
    const char *model, *variant, *dataset, *split, *crc32;
    bool synthetic;
    int samples, of;
    const char *row, *tables;       /* of the model; JSON of "tables" */
} scores;

/* Beside the model a predictor that is the same in every run */
static void scored(const char *run, scores s)
{
    char text[2048];

    snprintf(text, sizeof(text), "{\"model\":{\"name\":\"%s\",\"variant\":\"%s\"},\"train\":{\"seed\":0}}", s.model,
             s.variant);
    write_text(run, "config.json", text);
    snprintf(text, sizeof(text),
             "{\"model\":\"%s\",\"variant\":\"%s\",\"dataset\":\"%s\",\"data\":\"d\",\"data_crc32\":\"%s\","
             "\"synthetic\":%s,\"split\":\"%s\",\"samples\":%d,\"split_samples\":%d,\"hand\":\"h\",\"rows\":["
             "{\"predictor\":\"%s\",%s},{\"predictor\":\"zero predictor\",\"pa_mpjpe_mm\":50}],\"tables\":[%s]}",
             s.model, s.variant, s.dataset, s.crc32 ? s.crc32 : "1", s.synthetic ? "true" : "false", s.split, s.samples,
             s.of, s.model, s.row, s.tables ? s.tables : "");
    write_text(run, "eval/scores.json", text);
}

static const scores ho3d = {
    .model = "hocat", .variant = "full", .dataset = "HO3D v2", .split = "evaluation", .samples = 9, .of = 9,
    .row = "\"pa_mpjpe_mm\":12.5,\"pa_mpvpe_mm\":null,\"oce_mm\":20,\"parameters_mb\":4",
};

static void clear(void) { ck_assert_int_eq(system("rm -rf " RUNS), 0); }

static char *printed(void)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    eval_filled *f;

    ck_assert_int_eq(eval_filled_read(RUNS, &f), LT_OK);
    ck_assert_int_eq(eval_filled_print(f, out, EVAL_TEXT), LT_OK);
    fclose(out);
    eval_filled_free(f);
    return text;
}

static bool has(const char *text, const char *part) { return strstr(text, part); }

/* By key, under tables of the dataset: the ablation's row, and other papers', but not another dataset's. */
START_TEST(by_key)
{
    char *text;

    clear();
    scored("a", ho3d);
    text = printed();
    ck_assert(has(text, "HOCAT, Table 1") && has(text, "HOCAT, Table 5") && has(text, "estimator, Table 4"));
    ck_assert(!has(text, "HOCAT, Table 2"));            /* is about single objects */
    ck_assert(!has(text, "HOCAT, Table 3") && !has(text, "HOGS, Table 5"));
    ck_assert(has(text, "a: hocat full          HO3D v2            -                   12.5        failed        -"));
    ck_assert(has(text, "a: hocat full - HOCAT  HO3D v2 - HO3D v2                      +3.4        failed        -"));
    ck_assert(has(text, "; PAMPJPE: joints' mean error after the best similarity, reflections allowed ["));
    ck_assert(!has(text, "ynthetic"));
    free(text);
    clear();
}
END_TEST

/* A difference is of the same data alone: name, split, all samples, and no synthetic ones. */
START_TEST(differences)
{
    static const struct { const char *dataset, *split; bool synthetic; int samples; bool told; } cases[] = {
        { "HO3D v2", "evaluation", false, 9, true }, { "HO3D v2", "evaluation", true, 9, false },
        { "HO3D v3", "evaluation", false, 9, false }, { "HO3D v2", "val", false, 9, false },
        { "HO3D v2", "evaluation", false, 8, false }, { "HO3D v2 (part)", "evaluation", false, 9, false },
    };
    scores s = ho3d;
    char *text;

    clear();
    s.dataset = cases[_i].dataset;
    s.split = cases[_i].split;
    s.synthetic = cases[_i].synthetic;
    s.samples = cases[_i].samples;
    scored("a", s);
    text = printed();
    ck_assert_int_eq(has(text, "a: hocat full - HOCAT"), cases[_i].told);
    ck_assert_int_eq(has(text, " - HOCAT"), cases[_i].told);
    ck_assert_int_eq(has(text, "a: hocat full (synthetic)"), cases[_i].synthetic);
    ck_assert(!has(text, "- Unified"));                 /* another model reproduces none of its rows */
    free(text);
    clear();
}
END_TEST

/* DexYCB's tables name no setup: it is the first. */
START_TEST(dexycb_setups)
{
    scores s = ho3d;
    char *text;

    clear();
    s.model = "unified";
    s.variant = "no_aaf";
    s.dataset = _i ? "DexYCB s1" : "DexYCB s0";
    s.split = "test";
    s.row = "\"mpjpe_mm\":13";
    scored("a", s);
    text = printed();
    ck_assert_int_eq(has(text, "a: unified no_aaf - without adaptive fusion"), !_i);
    ck_assert(!has(text, "HOCAT, Table 5"));            /* no variant of that model */
    free(text);
    clear();
}
END_TEST

static double protocol_of_row(const cJSON *table, int i)
{
    return cJSON_GetObjectItem(cJSON_GetArrayItem(cJSON_GetObjectItem(table, "ours"), i), "protocol")->valuedouble;
}

/* Runs on the same data share a protocol and its predictors; others have a number of their own. */
START_TEST(groups)
{
    scores s = ho3d;
    eval_filled *f;
    cJSON *root;
    const cJSON *table;
    char *text;

    clear();
    s.synthetic = true;
    scored("a", s);
    s.variant = "dual";
    scored("b", s);
    s.crc32 = "2";
    scored("c", s);
    text = printed();
    ck_assert(has(text, "a: hocat full (synthetic)  ") && has(text, "  synthetic [1]") && has(text, "  synthetic [2]"));
    ck_assert(has(text, "Protocol [1]: SYNTHETIC") && has(text, "; data: d, crc32 2"));
    free(text);
    ck_assert_int_eq(eval_filled_read(RUNS, &f), LT_OK);
    root = eval_filled_json(f);
    table = cJSON_GetArrayItem(root, 0);
    ck_assert_str_eq(cJSON_GetObjectItem(table, "id")->valuestring, "hocat-1");
    ck_assert_int_eq(cJSON_GetArraySize(cJSON_GetObjectItem(table, "protocols")), 2);
    ck_assert_int_eq(cJSON_GetArraySize(cJSON_GetObjectItem(table, "ours")), 5);
    ck_assert_double_eq(protocol_of_row(table, 1), 1);
    ck_assert_double_eq(protocol_of_row(table, 2), 1);          /* the predictor, once */
    ck_assert_double_eq(protocol_of_row(table, 3), 2);
    cJSON_Delete(root);
    eval_filled_free(f);
    clear();
}
END_TEST

/* What palmar eval made of a table is taken as it is, columns about single objects too. */
START_TEST(as_scored)
{
    scores s = ho3d;
    char *text;

    clear();
    s.tables = "{\"id\":\"hocat-2\",\"ours\":[{\"label\":\"hocat\",\"values\":{\"can\":25,\"average\":25}}],"
               "\"protocol\":{\"failed\":1,\"threshold\":\"ADD <= 0.1 diameter\",\"from ground truth\":\"boxes\"}}";
    scored("a", s);
    text = printed();
    ck_assert(has(text, "a: hocat full          HO3D v2                       -           -     25.0         25.0"));
    ck_assert(has(text, "a: hocat full - HOCAT  HO3D v2 - HO3D v2             -           -    -23.5        -35.8"));
    ck_assert(has(text, "1 failed; alignment: -; threshold: ADD <= 0.1 diameter"));
    free(text);
    clear();
}
END_TEST

START_TEST(bad_input)
{
    eval_filled *f;

    clear();
    ck_assert_int_eq(eval_filled_read(RUNS, &f), LT_EIO);
    ck_assert_int_eq(lt_make_dirs(RUNS), LT_OK);
    ck_assert_int_eq(eval_filled_read(RUNS, &f), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), RUNS ": no scored run in it; want a folder of runs' folders, of which "
                                      "palmar eval scored some");
    scored("a", ho3d);
    write_text("a", "eval/scores.json",
               "{\"variant\":\"full\",\"rows\":7,\"tables\":[1,{\"id\":\"hocat-1\",\"ours\":[3]}]}");
    ck_assert_int_eq(eval_filled_read(RUNS, &f), LT_OK);
    eval_filled_free(f);
    write_text("a", "eval/scores.json", "{");
    ck_assert_int_eq(eval_filled_read(RUNS, &f), LT_EFORMAT);
    clear();
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_test(t, by_key);
    tcase_add_loop_test(t, differences, 0, 6);
    tcase_add_loop_test(t, dexycb_setups, 0, 2);
    tcase_add_test(t, groups);
    tcase_add_test(t, as_scored);
    tcase_add_test(t, bad_input);
}

int main(void)
{
    return run_suite("filled", add_tests);
}
