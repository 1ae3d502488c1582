/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Walking the lines of a text in memory: words, numbers, continuations.
 */
#ifndef LT_IO_TEXT_LINES_H
#define LT_IO_TEXT_LINES_H

#include "libtensor/base/common.h"

typedef struct {
    char *text, *next, *end;
    size_t number;                  /* of the line returned last, from 1 */
} lt_text_lines;

/* lt_lines_of - the lines of n characters and a NUL, none of them NUL, behind a byte order mark if there is one; a
 * backslash at a line's end joins it to the next. Lines end in LF, CR LF or CR. The text is changed: newlines become
 * NUL as lines are returned. */
lt_text_lines lt_lines_of(char *text, size_t n);

/* lt_next_line - the next line, NUL-terminated, or NULL at the end; lt_lines_rewind - begin again */
char *lt_next_line(lt_text_lines *lines);
void lt_lines_rewind(lt_text_lines *lines);

/* lt_line_is - the first word of line is word; *rest is what follows it, without leading blanks */
bool lt_line_is(const char *line, const char *word, const char **rest);

/* lt_skip_blanks - past spaces, tabs and carriage returns */
const char *lt_skip_blanks(const char *p);

/* lt_take_floats - up to max numbers at *p, past them; how many were finite numbers before the first
 * word that is none */
int lt_take_floats(const char **p, int max, float *out);

#endif
