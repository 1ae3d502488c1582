/* SPDX-License-Identifier: Apache-2.0 */
/* The lines of a file that grows line by line. What is behind the last newline was cut off, by whatever killed its
 * writer. */
#ifndef LT_IO_TEXT_RECORDS_H
#define LT_IO_TEXT_RECORDS_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct {
    const char *at, *end;
    int64_t number;                 /* of the line returned last, from 1 */
} lt_records;

static inline lt_records lt_records_of(const char *text, size_t n)
{
    return (lt_records){ text, text + n, 0 };
}

/* lt_next_record - the next whole line, *n characters without its newline; NULL behind the last */
static inline const char *lt_next_record(lt_records *r, size_t *n)
{
    const char *line = r->at, *newline = r->end > line ? memchr(line, '\n', (size_t)(r->end - line)) : NULL;

    if (!newline)
        return NULL;
    *n = (size_t)(newline - line);
    r->at = newline + 1;
    r->number++;
    return line;
}

/* lt_count_records - how many there are */
static inline int64_t lt_count_records(const char *text, size_t n)
{
    lt_records r = lt_records_of(text, n);
    size_t length;

    while (lt_next_record(&r, &length))
        ;
    return r.number;
}

#endif
