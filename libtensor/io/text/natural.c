/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/io/text/natural.h"

#include <stdbool.h>
#include <string.h>

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Two runs of digits as numbers, of which the longer without leading zeros is the larger; both are passed. */
static int compare_numbers(const char **a, const char **b)
{
    size_t n_a, n_b;
    int order;

    *a += strspn(*a, "0");
    *b += strspn(*b, "0");
    n_a = strspn(*a, "0123456789");
    n_b = strspn(*b, "0123456789");
    order = n_a != n_b ? (n_a < n_b ? -1 : 1) : memcmp(*a, *b, n_a);
    *a += n_a;
    *b += n_b;
    return order;
}

int lt_natural_order(const char *a, const char *b)
{
    const char *p = a, *q = b;

    while (*p && *q) {
        if (is_digit(*p) && is_digit(*q)) {
            const int order = compare_numbers(&p, &q);

            if (order)
                return order;
        } else if (*p != *q) {
            return (unsigned char)*p < (unsigned char)*q ? -1 : 1;
        } else {
            p++;
            q++;
        }
    }
    return *p ? 1 : *q ? -1 : strcmp(a, b);
}
