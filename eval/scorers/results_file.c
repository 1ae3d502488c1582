/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/scorers/results_file.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/lines.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#define MOST_BYTES ((size_t)2 << 30)

/* Whether a line is the header, however it is spaced. */
static bool is_header(const char *line, const char *header)
{
    for (; *header; header++, line++) {
        line = lt_skip_blanks(line);
        if (tolower((unsigned char)*line) != tolower((unsigned char)*header))
            return false;
    }
    return true;
}

/* The lines of text into rows. */
static lt_status parse(const char *path, char *text, size_t size, const results_format *f, char *rows, int64_t *n)
{
    lt_text_lines lines = lt_lines_of(text, size);
    bool begun = false;
    const char *line;

    *n = 0;
    while ((line = lt_next_line(&lines)) != NULL) {
        lt_status st;
        line = lt_skip_blanks(line);
        if (!*line)
            continue;
        if (f->header && !begun && isalpha((unsigned char)*line)) {
            if (!is_header(line, f->header))
                break;
            begun = true;
            continue;
        }
        begun = true;
        st = f->parse(path, (int64_t)lines.number, line, rows + (size_t)*n * f->row_size);
        if (st)
            return st;
        ++*n;
    }
    if (f->header && !begun)
        return lt_error(LT_EFORMAT, "%s: expected \"%s\" first, or lines of these", path, f->header);
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
    lines = size / f->shortest + 1;
    *rows = lt_arena_array(arena, lines, f->row_size);
    if (!*rows)
        return lt_error(LT_ENOMEM, "%s: no memory for %zu lines", path, lines);
    st = parse(path, (char *)bytes, size, f, *rows, n);
    if (st)
        return st;
    qsort(*rows, (size_t)*n, f->row_size, f->order);
    return LT_OK;
}
