/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Text of strangers on its way to a terminal: names in files, metadata, paths.
 */
#ifndef LT_BASE_PRINTABLE_H
#define LT_BASE_PRINTABLE_H

#include "libtensor/base/common.h"

#include <stdarg.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* lt_is_control - whether a character steers a terminal or the order of letters rather than being one: the control
 * codes of ASCII and of Latin 1 (U+0080 to U+009F), DEL, ends of lines and paragraphs, marks of direction */
LT_API bool lt_is_control(uint32_t code);

/* lt_printable - put '?' for each byte of such characters, and of what is no UTF-8, in place; returns text */
LT_API char *lt_printable(char *text);

/* lt_say - one line to f, made printable whole, and a newline behind it; what is longer than some 8 KB is cut */
LT_API void lt_say(FILE *f, const char *fmt, ...) LT_PRINTF(2, 3);
LT_API void lt_vsay(FILE *f, const char *fmt, va_list args);

#ifdef __cplusplus
}
#endif
#endif
