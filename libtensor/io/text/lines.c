/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Walking the lines of a text in memory.
 */
#include "libtensor/io/text/lines.h"

#include "libtensor/io/text/number.h"

#include <math.h>
#include <string.h>

/* Lines that end as on old Macs, in a carriage return alone, end in a newline from here on. */
static void end_in_newlines(char *p)
{
    for (; (p = strchr(p, '\r')) != NULL; p++)
        if (p[1] != '\n')
            *p = '\n';
}

lt_text_lines lt_lines_of(char *text, size_t n)
{
    char *first = strncmp(text, "\xef\xbb\xbf", 3) == 0 ? text + 3 : text;      /* UTF-8's byte order mark */
    const lt_text_lines lines = { first, first, text + n, 0 };
    char *p = first;

    end_in_newlines(first);
    while ((p = strchr(p, '\\')) != NULL) {
        const size_t joined = p[1] == '\n' ? 2 : p[1] == '\r' && p[2] == '\n' ? 3 : 0;

        memset(p, ' ', joined);
        p += joined ? joined : 1;
    }
    return lines;
}

/* A line ends in a newline when it is seen for the first time, in a NUL after that. */
char *lt_next_line(lt_text_lines *lines)
{
    char *line = lines->next, *end;

    if (line >= lines->end)
        return NULL;
    end = line + strcspn(line, "\n");
    *end = '\0';
    lines->next = end + 1;
    lines->number++;
    return line;
}

void lt_lines_rewind(lt_text_lines *lines)
{
    lines->next = lines->text;
    lines->number = 0;
}

const char *lt_skip_blanks(const char *p)
{
    return p + strspn(p, " \t\r");
}

bool lt_line_is(const char *line, const char *word, const char **rest)
{
    const size_t n = strlen(word);

    line = lt_skip_blanks(line);
    if (strncmp(line, word, n) != 0 || (line[n] != '\0' && !strchr(" \t\r", line[n])))
        return false;
    *rest = lt_skip_blanks(line + n);
    return true;
}

int lt_take_floats(const char **p, int max, float *out)
{
    int n = 0;

    while (n < max) {
        const char *end;
        const double x = lt_strtod(*p, &end);

        if (end == *p || !isfinite((float)x) || (*end != '\0' && !strchr(" \t\r", *end)))
            break;
        out[n++] = (float)x;
        *p = end;
    }
    return n;
}
