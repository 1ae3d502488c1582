/* SPDX-License-Identifier: Apache-2.0 */
/* The claims ledger over run folders written here. */
#include "eval/tables/claims.h"
#include "libtensor/io/file.h"
#include "models/model.h"
#include "tests/suite.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RUNS "test_claims.dir"

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

static const char *data_crc32 = "0";

/* A run that was scored; value as JSON text. */
static void scored_by(const char *who, const char *key, const char *run, const char *variant, int seed, int epochs,
                      const char *value)
{
    char text[512];

    snprintf(text, sizeof(text),
             "{\"model\":{\"name\":\"%s\",\"variant\":\"%s\"},\"optim\":{\"epochs\":%d},\"train\":{\"seed\":%d}}",
             who, variant, epochs, seed);
    write_text(run, "config.json", text);
    snprintf(text, sizeof(text),
             "{\"model\":\"%s\",\"variant\":\"%s\",\"dataset\":\"HO3D v3\",\"synthetic\":true,"
             "\"data_crc32\":\"%s\","
             "\"split\":\"evaluation\",\"samples\":80,\"hand\":\"h\",\"rows\":[{\"%s\":%s},{\"%s\":1}]}",
             who, variant, data_crc32, key, value, key);
    write_text(run, "eval/scores.json", text);
}

static void scored(const char *run, const char *variant, int seed, int epochs, const char *pa)
{
    scored_by("hocat", "pa_mpjpe_mm", run, variant, seed, epochs, pa);
}

static void clear(void) { ck_assert_int_eq(system("rm -rf " RUNS), 0); }

static cJSON *ledger(void)
{
    eval_claims *c;
    cJSON *root;

    ck_assert_int_eq(eval_claims_read(RUNS, &c), LT_OK);
    root = eval_claims_json(c);
    eval_claims_free(c);
    return root;
}

/* The findings on the first claim of a model in a metric. */
static const cJSON *findings_on(const cJSON *root, const char *who, const char *better, const char *key)
{
    const cJSON *claim;

    cJSON_ArrayForEach(claim, root)
        if (!strcmp(cJSON_GetObjectItem(claim, "model")->valuestring, who)
            && !strcmp(cJSON_GetObjectItem(claim, "better")->valuestring, better)
            && !strcmp(cJSON_GetObjectItem(claim, "metric")->valuestring, key))
            return cJSON_GetObjectItem(claim, "findings");
    return NULL;
}

static const cJSON *findings(const cJSON *root, const char *better)
{
    return findings_on(root, "hocat", better, "pa_mpjpe_mm");
}

static double number(const cJSON *found, const char *key) { return cJSON_GetObjectItem(found, key)->valuedouble; }

START_TEST(pairs)
{
    const cJSON *found;
    cJSON *root;

    clear();
    scored("a", "full", 0, 5, "7");
    scored("b", "dual", 0, 5, "8.5");
    scored("c", "full", 1, 5, "9");
    scored("d", "dual", 1, 5, "8.5");
    scored("e", "dual", 2, 5, "1");             /* no full run of that seed */
    scored("f", "base", 0, 6, "1");             /* another number of epochs */
    root = ledger();
    ck_assert_int_eq(cJSON_GetArraySize(findings(root, "full")), 1);
    ck_assert_int_eq(cJSON_GetArraySize(findings(root, "dual")), 0);
    found = cJSON_GetArrayItem(findings(root, "full"), 0);
    ck_assert_double_eq(number(found, "seeds"), 2);
    ck_assert_double_eq(number(found, "held"), 1);
    ck_assert_double_eq(number(found, "mean_better"), 8);
    ck_assert_double_eq(number(found, "mean_worse"), 8.5);
    ck_assert_double_eq(number(found, "mean_margin"), 0.5);
    ck_assert_double_eq(number(found, "least_margin"), -0.5);
    ck_assert_double_eq(number(found, "most_margin"), 1.5);
    cJSON_Delete(root);
    clear();
}
END_TEST

/* Runs that were scored on other data are no pair, however alike the rest. */
START_TEST(other_data)
{
    cJSON *root;

    clear();
    scored("a", "full", 0, 5, "7");
    data_crc32 = "1";
    scored("b", "dual", 0, 5, "8.5");
    data_crc32 = "0";
    root = ledger();
    ck_assert_int_eq(cJSON_GetArraySize(findings(root, "full")), 0);
    cJSON_Delete(root);
    clear();
}
END_TEST

/* Equal scores do not hold, and a score that was not finite never does. */
START_TEST(ties_and_failures)
{
    const cJSON *found;
    cJSON *root;

    clear();
    scored("a", "full", 0, 5, "7");
    scored("b", "dual", 0, 5, "7");
    scored("c", "base", 0, 5, "null");
    root = ledger();
    ck_assert_double_eq(number(cJSON_GetArrayItem(findings(root, "full"), 0), "held"), 0);
    found = cJSON_GetArrayItem(findings(root, "dual"), 0);
    ck_assert_double_eq(number(found, "held"), 1);
    cJSON_Delete(root);
    scored("b", "dual", 0, 5, "null");
    root = ledger();
    ck_assert_double_eq(number(cJSON_GetArrayItem(findings(root, "dual"), 0), "held"), 0);
    cJSON_Delete(root);
    clear();
}
END_TEST

/* Of shares and areas the higher is ahead; a run whose scores are without the metric has no part in the claim. */
START_TEST(higher_is_ahead)
{
    const cJSON *found;
    cJSON *root;

    clear();
    scored_by("unified", "adds_auc", "a", "full", 0, 5, "0.5");
    scored_by("unified", "adds_auc", "b", "no_depth", 0, 5, "0.25");
    scored_by("unified", "adds_auc", "c", "full", 1, 5, "null");
    scored_by("unified", "adds_auc", "d", "no_depth", 1, 5, "0.25");
    scored_by("unified", "pa_mpjpe_mm", "e", "full", 2, 5, "7");
    scored_by("unified", "adds_auc", "f", "no_depth", 2, 5, "0.25");
    root = ledger();
    found = cJSON_GetArrayItem(findings_on(root, "unified", "full", "adds_auc"), 0);
    ck_assert_double_eq(number(found, "seeds"), 2);
    ck_assert_double_eq(number(found, "held"), 1);
    ck_assert_double_eq(number(found, "most_margin"), 0.25);
    ck_assert_int_eq(cJSON_GetArraySize(findings_on(root, "unified", "full", "pa_mpjpe_mm")), 0);
    cJSON_Delete(root);
    clear();
}
END_TEST

/* A run with a baseline's row beside the model's. */
static void scored_beside(const char *run, int seed, const char *mce, const char *baseline)
{
    char text[512];

    scored_by("hogs", "mce_mm", run, "full", seed, 5, mce);
    snprintf(text, sizeof(text),
             "{\"model\":\"hogs\",\"variant\":\"full\",\"dataset\":\"DexYCB s0\",\"synthetic\":true,\"samples\":8,"
             "\"rows\":[{\"predictor\":\"hogs\",\"mce_mm\":%s},{\"predictor\":\"initial poses\",\"mce_mm\":%s}]}",
             mce, baseline);
    write_text(run, "eval/scores.json", text);
}

/* What a run comes to against a row of its own; one that has no such row says nothing. */
START_TEST(baseline)
{
    const cJSON *found;
    cJSON *root;

    clear();
    scored_beside("a", 0, "26", "27.5");
    scored_beside("b", 1, "28", "27.5");
    scored_by("hogs", "mce_mm", "c", "full", 2, 5, "1");
    root = ledger();
    found = cJSON_GetArrayItem(findings_on(root, "hogs", "full", "mce_mm"), 0);
    ck_assert_int_eq(cJSON_GetArraySize(findings_on(root, "hogs", "full", "mce_mm")), 1);
    ck_assert_double_eq(number(found, "seeds"), 2);
    ck_assert_double_eq(number(found, "held"), 1);
    ck_assert_double_eq(number(found, "mean_better"), 27);
    ck_assert_double_eq(number(found, "most_margin"), 1.5);
    cJSON_Delete(root);
    clear();
}
END_TEST

static void psnr(const char *run, const char *variant, int seed, const char *value)
{
    scored_by("hogs", "psnr_db", run, variant, seed, 5, value);
}

static const cJSON *drops(const cJSON *root)
{
    const cJSON *claim;

    cJSON_ArrayForEach(claim, root)
        if (!strcmp(cJSON_GetObjectItem(claim, "kind")->valuestring, "drop")
            && !strcmp(cJSON_GetObjectItem(claim, "worse")->valuestring, "no-vpm"))
            return claim;
    return NULL;
}

/* Four runs of a seed: who loses less when it is made harder, whoever is ahead. */
START_TEST(drop)
{
    const cJSON *claim, *found;
    cJSON *root;

    clear();
    psnr("a", "full", 0, "30");
    psnr("b", "full-cj", 0, "29.75");
    psnr("c", "no-vpm", 0, "31");
    psnr("d", "no-vpm-cj", 0, "30");
    psnr("e", "full", 1, "30");
    psnr("f", "full-cj", 1, "null");
    psnr("g", "no-vpm", 1, "31");
    psnr("h", "no-vpm-cj", 1, "30");
    psnr("i", "full", 2, "30");                 /* without a harder one */
    psnr("j", "no-vpm", 2, "30");
    psnr("k", "no-vpm-cj", 2, "30");
    root = ledger();
    claim = drops(root);
    ck_assert_double_eq_tol(number(claim, "paper_better"), 0.12, 1e-9);     /* of Table 6: 31.12 to 31.00 */
    ck_assert_double_eq_tol(number(claim, "paper_worse"), 0.25, 1e-9);
    ck_assert_str_eq(cJSON_GetObjectItem(claim, "harder")->valuestring, "-cj");
    found = cJSON_GetArrayItem(cJSON_GetObjectItem(claim, "findings"), 0);
    ck_assert_double_eq(number(found, "seeds"), 2);
    ck_assert_double_eq(number(found, "held"), 1);
    ck_assert_double_eq(number(found, "most_margin"), 0.75);
    cJSON_Delete(root);
    clear();
}
END_TEST

START_TEST(printed)
{
    char text[8192] = "";
    eval_claims *c;
    FILE *f = fmemopen(text, sizeof(text), "w");

    clear();
    scored("a", "full", 0, 5, "7");
    scored("b", "dual", 0, 5, "8.5");
    ck_assert_int_eq(eval_claims_read(RUNS, &c), LT_OK);
    eval_claims_print(c, f);
    fclose(f);
    eval_claims_free(c);
    ck_assert(strstr(text, "| HOCAT, Table 5 | full before dual | pa_mpjpe_mm | 9.10 / 10.10 | 7.00 / 8.50 | "
                           "+1.50 (+1.50 .. +1.50) | 1 of 1, few seeds | HO3D v3 layout, SYNTHETIC, evaluation, 80 "
                           "samples |\n"));
    ck_assert(strstr(text, "| HOCAT, Table 5 | dual before base | pa_mpjpe_mm | 10.10 / 11.00 | - | - | not tried | - "
                     "|\n"));
    clear();
}
END_TEST

START_TEST(bad_input)
{
    eval_claims *c;

    clear();
    ck_assert_int_eq(eval_claims_read(RUNS, &c), LT_EIO);
    ck_assert_str_eq(lt_last_error(), RUNS ": No such file or directory");
    scored("a", "full", 0, 5, "7");
    write_text("a", "config.json", "{}");
    ck_assert_int_eq(eval_claims_read(RUNS, &c), LT_EFORMAT);
    ck_assert_str_eq(lt_last_error(), RUNS "/a/config.json: not the config of a run that was scored; score it again");
    write_text("a", "config.json", "{");
    ck_assert_int_eq(eval_claims_read(RUNS, &c), LT_EFORMAT);
    clear();
}
END_TEST

/* Claims name variants that exist, of those models that do, and the paper's figures differ. */
START_TEST(claims_name_variants)
{
    eval_claim claim;

    for (int i = 0; eval_claim_at(i, &claim); i++) {
        const bool higher = claim.kind != EVAL_CLAIM_DROP && claim.what->higher;

        if (!isnan(claim.paper_better - claim.paper_worse))     /* the paper has both */
            ck_assert(higher ? claim.paper_better > claim.paper_worse : claim.paper_better < claim.paper_worse);
        ck_assert_ptr_nonnull(claim.table->cite);
        for (int k = 0; model_classes[k]; k++) {
            bool better = false, worse = false;

            if (strcmp(model_classes[k]->name, claim.model))
                continue;
            for (const char *const *v = model_classes[k]->variants; *v; v++) {
                better |= !strcmp(*v, claim.better);
                worse |= !strcmp(*v, claim.worse) || claim.kind == EVAL_CLAIM_BASELINE;    /* a row */
            }
            ck_assert_msg(better && worse, "%s: %s, %s", claim.model, claim.better, claim.worse);
        }
    }
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_test(t, pairs);
    tcase_add_test(t, other_data);
    tcase_add_test(t, ties_and_failures);
    tcase_add_test(t, higher_is_ahead);
    tcase_add_test(t, baseline);
    tcase_add_test(t, drop);
    tcase_add_test(t, printed);
    tcase_add_test(t, bad_input);
    tcase_add_test(t, claims_name_variants);
}

int main(void)
{
    return run_suite("claims", add_tests);
}
