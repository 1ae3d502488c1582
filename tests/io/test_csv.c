/* SPDX-License-Identifier: Apache-2.0 */
/* CSV files of errors. */
#include "libtensor/io/text/csv.h"
#include "tests/suite.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

#define PATH "errors.csv"

START_TEST(csv)
{
    static const char *const metric[] = { "pa_mpjpe_mm", "f, \"aligned\"" };
    const double plain[2] = { 9.5, .75 }, failed[2] = { INFINITY, NAN };
    char text[256] = "";
    lt_csv w;
    FILE *f;

    ck_assert_int_eq(lt_csv_open(&w, PATH, "sample", 2, metric), LT_OK);
    lt_csv_add(&w, "ABF10/0123", plain);
    lt_csv_add(&w, "odd,\"name\"\n", failed);
    lt_csv_add(&w, "\033[2J \302\233 \xc3\xa9 \x9b \r", plain);
    ck_assert_int_eq(lt_csv_commit(&w), LT_OK);
    f = fopen(PATH, "r");
    ck_assert_uint_gt(fread(text, 1, sizeof(text) - 1, f), 0);
    fclose(f);
    unlink(PATH);
    ck_assert_str_eq(text, "sample,pa_mpjpe_mm,\"f, \"\"aligned\"\"\"\nABF10/0123,9.5,0.75\n"
                           "\"odd,\"\"name\"\"\n\",inf,\n\"?[2J ? \xc3\xa9 \xef\xbf\xbd ?\",9.5,0.75\n");
}
END_TEST

START_TEST(fields_of_a_line)
{
    char text[] = "\"odd,\"\"name\"\"\",inf,,\"\",x\"y,", *rest = text;

    ck_assert_str_eq(lt_csv_field(&rest), "odd,\"name\"");
    ck_assert_str_eq(lt_csv_field(&rest), "inf");
    ck_assert_str_eq(lt_csv_field(&rest), "");
    ck_assert_str_eq(lt_csv_field(&rest), "");
    ck_assert_str_eq(lt_csv_field(&rest), "xy,");         /* no line of ours: a quote that nobody closes */
    ck_assert_ptr_null(lt_csv_field(&rest));
    ck_assert_ptr_null(lt_csv_field(&rest));
}
END_TEST

START_TEST(no_folder)
{
    static const char *const metric[] = { "x" };
    lt_csv w;

    ck_assert_int_eq(lt_csv_open(&w, "no/such/folder.csv", "sample", 1, metric), LT_EIO);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_test(t, csv);
    tcase_add_test(t, fields_of_a_line);
    tcase_add_test(t, no_folder);
}

int main(void)
{
    return run_suite("csv", add_tests);
}
