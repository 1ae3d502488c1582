/* SPDX-License-Identifier: Apache-2.0 */
/* What scores must come to, as it is typed. */
#include "eval/tables/require.h"

#include "tests/suite.h"

#include <math.h>
#include <string.h>

static const char *made(int i)
{
    static const char *const keys[] = { "pa_mpjpe_mm", "mpjpe_mm", "f5_percent", "adds_auc", NULL };

    return keys[i];
}

START_TEST(reads)
{
    eval_requirement r;

    ck_assert_int_eq(eval_require_read("pa_mpjpe_mm<=12.5", made, &r), LT_OK);
    ck_assert_str_eq(r.what->key, "pa_mpjpe_mm");
    ck_assert(!r.at_least && r.bound == 12.5);
    ck_assert_int_eq(eval_require_read(" adds_auc >= .8 ", made, &r), LT_OK);
    ck_assert_str_eq(r.what->key, "adds_auc");
    ck_assert(r.at_least && r.bound == .8);
}
END_TEST

static const struct { const char *text, *line; } wrong[] = {
    { "pa_mpjp_mm<=1", "--require pa_mpjp_mm: no such key; did you mean \"pa_mpjpe_mm\"?" },
    { "PA-MPJPE<=1", "--require PA-MPJPE: no such key; did you mean \"pa_mpjpe_mm\"?" },
    { "auc>=1", "--require auc: no such key; did you mean \"adds_auc\"?" },
    { "f5>=1", "--require f5: no such key; did you mean \"f5_percent\"?" },
    { "psnr_db>=1", "--require psnr_db: is not scored here; docs/formats.md lists those that are" },
    { "pa_mpjpe_mm<12", "--require: found \"pa_mpjpe_mm<12\", want KEY>=X or KEY<=X, as \"pa_mpjpe_mm<=12\"" },
    { "pa_mpjpe_mm", "--require: found \"pa_mpjpe_mm\", want KEY>=X or KEY<=X, as \"pa_mpjpe_mm<=12\"" },
    { "<=3", "--require: found \"<=3\", want KEY>=X or KEY<=X, as \"pa_mpjpe_mm<=12\"" },
    { "", "--require: found \"\", want KEY>=X or KEY<=X, as \"pa_mpjpe_mm<=12\"" },
    { "mpjpe_mm<=", "--require: found \"mpjpe_mm<=\", want a number behind <=" },
    { "mpjpe_mm<=nan", "--require: found \"mpjpe_mm<=nan\", want a number behind <=" },
    { "mpjpe_mm>=3mm", "--require: found \"mpjpe_mm>=3mm\", want a number behind >=" },
};

START_TEST(refuses)
{
    eval_requirement r;

    ck_assert_int_eq(eval_require_read(wrong[_i].text, made, &r), LT_EUSAGE);
    ck_assert_str_eq(lt_last_error(), wrong[_i].line);
}
END_TEST

static double score(const void *ctx, const char *key)
{
    const double *value = ctx;

    return !strcmp(key, "pa_mpjpe_mm") ? value[0] : !strcmp(key, "adds_auc") ? value[1] : NAN;
}

START_TEST(holds)
{
    const double value[] = { 9.1, 0.7 };
    eval_requirement r[3];

    ck_assert_int_eq(eval_require(NULL, 0, score, value), LT_OK);
    eval_require_read("pa_mpjpe_mm<=9.1", made, &r[0]);
    eval_require_read("adds_auc>=0.7", made, &r[1]);
    ck_assert_int_eq(eval_require(r, 2, score, value), LT_OK);
    eval_require_read("adds_auc>=0.8", made, &r[1]);
    ck_assert_int_eq(eval_require(r, 2, score, value), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "AUC of ADD-S is 0.70, want at least 0.80");
    eval_require_read("pa_mpjpe_mm<=9.099", made, &r[0]);       /* told apart to the last decimal that matters */
    eval_require_read("f5_percent>=1", made, &r[2]);
    ck_assert_int_eq(eval_require(r, 3, score, value), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "PA-MPJPE is 9.100 mm, want at most 9.099; AUC of ADD-S is 0.70, want at least "
                                      "0.80; F@5 could not be measured, want at least 1.00");
}
END_TEST

START_TEST(what_failed_meets_nothing)
{
    const double value[] = { INFINITY, NAN };
    eval_requirement r;

    eval_require_read("pa_mpjpe_mm<=1e300", made, &r);
    ck_assert_int_eq(eval_require(&r, 1, score, value), LT_EINVAL);
    eval_require_read("adds_auc<=1", made, &r);
    ck_assert_int_eq(eval_require(&r, 1, score, value), LT_EINVAL);
}
END_TEST

/* One key, one meaning; and nothing left out. */
START_TEST(dictionary)
{
    int n = 0;

    for (const metric *m; (m = metric_at(n)); n++) {
        ck_assert_ptr_eq(metric_find(m->key), m);
        ck_assert(*m->name && m->unit && *m->meaning && *m->source);
        ck_assert_int_eq(strspn(m->key, "abcdefghijklmnopqrstuvwxyz0123456789_"), strlen(m->key));
    }
    ck_assert_int_gt(n, 40);
    ck_assert_ptr_null(metric_at(-1));
    ck_assert_ptr_null(metric_find("pa-mpjpe"));
    ck_assert(metric_better(metric_find("pa_mpjpe_mm"), 1, 2) && metric_better(metric_find("f5_percent"), 2, 1));
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_test(t, reads);
    tcase_add_loop_test(t, refuses, 0, sizeof(wrong) / sizeof(*wrong));
    tcase_add_test(t, holds);
    tcase_add_test(t, what_failed_meets_nothing);
    tcase_add_test(t, dictionary);
}

int main(void)
{
    return run_suite("require", add_tests);
}
