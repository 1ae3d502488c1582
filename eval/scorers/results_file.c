/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/scorers/results_file.h"

#include "libtensor/io/file.h"

#include <stdlib.h>
#include <string.h>

#define MOST_BYTES ((size_t)2 << 30)

/* The lines of text into rows. */
static lt_status parse(const char *path, char *text, const results_format *f, char *rows, int64_t *n)
{
    int64_t number = 0;

    *n = 0;
    for (char *line; (line = strsep(&text, "\n")) != NULL; ) {
        lt_status st;
        number++;
        if (!*line || (number == 1 && f->header))
            continue;
        st = f->parse(path, number, line, rows + (size_t)*n * f->row_size);
        if (st)
            return st;
        ++*n;
    }
    return LT_OK;
}

lt_status results_file_read(lt_arena *arena, const char *path, const results_format *f, void **rows, int64_t *n)
{
    uint8_t *bytes;
    size_t size, lines;
    lt_status st = lt_read_file(arena, path, MOST_BYTES, &bytes, &size);

    if (st)
        return st;
    if (memchr(bytes, 0, size))
        return lt_error(LT_EFORMAT, "%s: found a NUL byte, expected text", path);
    if (f->header && strncmp((char *)bytes, f->header, strlen(f->header)))
        return lt_error(LT_EFORMAT, "%s: expected \"%s\" first", path, f->header);
    lines = size / f->shortest + 1;
    *rows = lt_arena_array(arena, lines, f->row_size);
    if (!*rows)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu lines", path, lines);
    st = parse(path, (char *)bytes, f, *rows, n);
    if (st)
        return st;
    qsort(*rows, (size_t)*n, f->row_size, f->order);
    return LT_OK;
}
