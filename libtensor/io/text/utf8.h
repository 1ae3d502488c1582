/* SPDX-License-Identifier: Apache-2.0 */
/*
 * UTF-8, one character at a time.
 */
#ifndef LT_IO_TEXT_UTF8_H
#define LT_IO_TEXT_UTF8_H

#include "libtensor/base/common.h"

enum { LT_UTF8_MAX = 4 };

/* lt_utf8_put - code into out; how many bytes that is, 0 when there is no such character */
size_t lt_utf8_put(char out[LT_UTF8_MAX], uint32_t code);

/* lt_utf8_next - the character at *p < end, and past it; a byte that begins none gives U+FFFD */
uint32_t lt_utf8_next(const char **p, const char *end);

#endif
