/* SPDX-License-Identifier: Apache-2.0 */
/* The CSV of per-sample errors. */
#include "eval/per_sample.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PATH "test_per_sample.csv"

START_TEST(csv)
{
    static const char *const metric[] = { "pa_mpjpe_mm", "f, \"aligned\"" };
    const double plain[2] = { 9.5, .75 }, failed[2] = { INFINITY, NAN };
    char text[256] = "";
    eval_per_sample w;
    FILE *f;

    ck_assert_int_eq(eval_per_sample_open(&w, PATH, 2, metric), LT_OK);
    eval_per_sample_add(&w, "ABF10/0123", plain);
    eval_per_sample_add(&w, "odd,\"name\"\n", failed);
    ck_assert_int_eq(eval_per_sample_commit(&w), LT_OK);
    f = fopen(PATH, "r");
    ck_assert_uint_gt(fread(text, 1, sizeof(text) - 1, f), 0);
    fclose(f);
    unlink(PATH);
    ck_assert_str_eq(text, "sample,pa_mpjpe_mm,\"f, \"\"aligned\"\"\"\nABF10/0123,9.5,0.75\n"
                           "\"odd,\"\"name\"\"\n\",inf,\n");
}
END_TEST

START_TEST(nothing_left)
{
    static const char *const metric[] = { "x" };
    eval_per_sample w;

    ck_assert_int_eq(eval_per_sample_open(&w, "no/such/folder.csv", 1, metric), LT_EIO);
    ck_assert_int_eq(eval_per_sample_open(&w, PATH, 1, metric), LT_OK);
    eval_per_sample_abort(&w);
    ck_assert_int_ne(access(PATH, F_OK), 0);
}
END_TEST

int main(void)
{
    TCase *t = tcase_create("per_sample");
    Suite *s = suite_create("per_sample");
    SRunner *r;
    int failed;

    tcase_add_test(t, csv);
    tcase_add_test(t, nothing_left);
    suite_add_tcase(s, t);
    r = srunner_create(s);
    srunner_run_all(r, CK_NORMAL);
    failed = srunner_ntests_failed(r);
    srunner_free(r);
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
