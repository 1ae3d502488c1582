/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Numbers as text, in the C locale.
 */
#include "libtensor/io/text/number.h"

#include <locale.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

static locale_t c_locale;               /* (locale_t)0 when there is none to be had */

static void make_c_locale(void)
{
    c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

static locale_t enter_c_locale(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;

    pthread_once(&once, make_c_locale);
    return uselocale(c_locale);         /* of this thread only; 0 changes nothing */
}

/* A plain decimal of up to 15 digits, which double division by a power of ten below 10^22 rounds correctly [Clinger
 * 1990]; false: something else, or longer. Files of coordinates have a hundred million of these. */
static bool plain_decimal(const char *text, const char **end, double *out)
{
    static const double power[] = { 1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14,
                                    1e15 };
    const char *p = text + (*text == '-');
    int64_t digits = 0;
    int n = 0, behind = 0;

    for (; *p >= '0' && *p <= '9' && n < 16; n++)
        digits = 10 * digits + (*p++ - '0');
    if (n && *p == '.')
        for (p++; *p >= '0' && *p <= '9' && n < 16; n++, behind++)
            digits = 10 * digits + (*p++ - '0');
    if (!n || n > 15 || (*p >= '0' && *p <= '9') || *p == '.' || *p == 'e' || *p == 'E' || *p == 'x' || *p == 'X')
        return false;
    *out = (double)digits / power[behind];
    if (*text == '-')
        *out = -*out;
    *end = p;
    return true;
}

static double c_strtod(const char *text, const char **end)
{
    const locale_t old = enter_c_locale();
    char *stop;
    const double x = strtod(text, &stop);

    uselocale(old);
    *end = stop;
    return x;
}

double lt_strtod(const char *text, const char **end)
{
    double x;

    return plain_decimal(text, end, &x) ? x : c_strtod(text, end);
}

const char *lt_print_double(double x, char out[LT_NUMBER_TEXT])
{
    const locale_t old = enter_c_locale();

    for (int digits = 15; digits <= 17; digits++) {
        snprintf(out, LT_NUMBER_TEXT, "%.*g", digits, x);
        if (strtod(out, NULL) == x)
            break;
    }
    uselocale(old);
    return out;
}

const char *lt_print_float(float x, char out[LT_NUMBER_TEXT])
{
    const locale_t old = enter_c_locale();

    for (int digits = 6; digits <= 9; digits++) {
        snprintf(out, LT_NUMBER_TEXT, "%.*g", digits, (double)x);
        if (strtof(out, NULL) == x)
            break;
    }
    uselocale(old);
    return out;
}
