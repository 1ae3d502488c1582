/* SPDX-License-Identifier: Apache-2.0 */
/* Names that were mistyped, and what is said of them. */
#include "libtensor/io/text/nearest.h"
#include "tests/suite.h"

START_TEST(the_nearest_name)
{
    static const char *const list[] = { "lr", "steps", "batch_size", "weight_decay" };
    char longer[500] = "";

    ck_assert_str_eq(lt_nearest_name("lrr", list, 4), "lr");
    ck_assert_str_eq(lt_nearest_name("step", list, 4), "steps");
    ck_assert_str_eq(lt_nearest_name("setps", list, 4), "steps");
    ck_assert_str_eq(lt_nearest_name("wieght_decy", list, 4), "weight_decay");
    ck_assert_ptr_null(lt_nearest_name("colour", list, 4));
    ck_assert_ptr_null(lt_nearest_name("x", list, 4));
    ck_assert_ptr_null(lt_nearest_name("lr", list, 0));
    memset(longer, 'l', sizeof(longer) - 1);
    ck_assert_ptr_null(lt_nearest_name(longer, list, 4));
    ck_assert_ptr_null(lt_nearest_name("lr", (const char *const[]){ longer }, 1));
}
END_TEST

START_TEST(what_is_said_of_an_unknown_name)
{
    static const char *const list[] = { "hocat", "unified" };

    ck_assert_int_eq(lt_unknown_name("hokat", list, 2, "there are two", "no such model \"%s\"", "hokat"), LT_EINVAL);
    ck_assert_str_eq(lt_last_error(), "no such model \"hokat\"; did you mean \"hocat\"?");
    lt_unknown_name("x", list, 2, "there are two", "no such model \"%s\"", "x");
    ck_assert_str_eq(lt_last_error(), "no such model \"x\"; there are two");
    lt_unknown_name("x", list, 2, NULL, "no such model \"%s\"", "x");
    ck_assert_str_eq(lt_last_error(), "no such model \"x\"; did you mean \"hocat\"?");
    lt_unknown_name("x", list, 0, "there are: none", "no such model");
    ck_assert_str_eq(lt_last_error(), "no such model; there are: none");
}
END_TEST

static void add(TCase *tc)
{
    tcase_add_test(tc, the_nearest_name);
    tcase_add_test(tc, what_is_said_of_an_unknown_name);
}

int main(void)
{
    return run_suite("nearest", add);
}
