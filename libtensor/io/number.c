/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Numbers as text, in the C locale.
 */
#include "libtensor/io/number.h"

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

double lt_strtod(const char *text, const char **end)
{
    const locale_t old = enter_c_locale();
    char *stop;
    const double x = strtod(text, &stop);

    uselocale(old);
    *end = stop;
    return x;
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
