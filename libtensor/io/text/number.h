/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Numbers as text, correctly rounded and with a point, whatever locale the program runs in.
 */
#ifndef LT_IO_TEXT_NUMBER_H
#define LT_IO_TEXT_NUMBER_H

#include "libtensor/base/common.h"

enum { LT_NUMBER_TEXT = 32 };

/* lt_strtod - strtod in the C locale; text ends with a NUL, *end is text when there is no number */
double lt_strtod(const char *text, const char **end);

/* lt_print_double, lt_print_float - the shortest of the usual precisions that reads back as x */
const char *lt_print_double(double x, char out[LT_NUMBER_TEXT]);
const char *lt_print_float(float x, char out[LT_NUMBER_TEXT]);

#endif
