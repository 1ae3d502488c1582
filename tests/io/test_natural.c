/* SPDX-License-Identifier: Apache-2.0 */
/* Names in the order of the numbers in them. */
#include "libtensor/io/text/natural.h"
#include "tests/suite.h"

#include <stdlib.h>

static int sign(int x)
{
    return (x > 0) - (x < 0);
}

/* Each list is in order; every pair of it is compared, both ways round. */
static void check_order(const char *const *name, int n)
{
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++)
            ck_assert_msg(sign(lt_natural_order(name[i], name[k])) == sign(i - k), "%s, %s", name[i], name[k]);
}

START_TEST(order)
{
    static const char *const frames[] = { "frame1.jpg", "frame2.jpg", "frame9.jpg", "frame10.jpg", "frame0011.jpg",
                                          "frame12.jpg", "frame100.jpg" };
    static const char *const longer[] = { "9999.png", "10000.png", "1305031102175304000.png",
                                          "98765432109876543210987654321.png", "x.png" };
    static const char *const parts[] = { "", "0", "00", "01", "1", "1a", "2", "a", "a1b2", "a1b10", "a2b1", "a10b1",
                                         "ab", "\xc3\xbc" };
    static const char *const folders[] = { "take2/frame10.png", "take10/frame2.png", "take10/frame10.png" };

    check_order(frames, LT_COUNT(frames));
    check_order(longer, LT_COUNT(longer));
    check_order(parts, LT_COUNT(parts));
    check_order(folders, LT_COUNT(folders));
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_test(t, order);
}

int main(void)
{
    return run_suite("natural order", add_tests);
}
