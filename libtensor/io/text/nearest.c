/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/io/text/nearest.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { NAME_MAX_CHARS = 64 };

static int min_int(int a, int b)
{
    return a < b ? a : b;
}

static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c + 'a' - 'A') : c;
}

/* Edits from a to b, capitals or not: insert, delete, replace, swap neighbours (optimal string alignment). */
static int edit_distance(const char *a, size_t n_a, const char *b, size_t n_b)
{
    int rows[3][NAME_MAX_CHARS + 1];
    int *before = rows[0], *last = rows[1], *row = rows[2];

    for (size_t j = 0; j <= n_b; j++)
        last[j] = (int)j;
    for (size_t i = 1; i <= n_a; i++) {
        int *spare = before;

        row[0] = (int)i;
        for (size_t j = 1; j <= n_b; j++) {
            row[j] = min_int(min_int(last[j], row[j - 1]) + 1, last[j - 1] + (lower(a[i - 1]) != lower(b[j - 1])));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = min_int(row[j], before[j - 2] + 1);
        }
        before = last;
        last = row;
        row = spare;
    }
    return last[n_b];
}

const char *lt_nearest_name(const char *name, const char *const *list, size_t n)
{
    const size_t length = strlen(name);
    int best = 1 + (length / 3 > 2 ? (int)(length / 3) : 2);
    const char *nearest = NULL;

    for (size_t i = 0; i < n && length <= NAME_MAX_CHARS; i++) {
        const size_t other = strlen(list[i]);
        const int d = other <= NAME_MAX_CHARS ? edit_distance(name, length, list[i], other) : best;

        if (d < best && d < (int)(other > length ? other : length)) {
            best = d;
            nearest = list[i];
        }
    }
    return nearest;
}

lt_status lt_unknown_name(const char *name, const char *const *list, size_t n, const char *otherwise,
                          const char *fmt, ...)
{
    const char *near = lt_nearest_name(name, list, n);
    char what[1024];
    va_list args;

    va_start(args, fmt);
    vsnprintf(what, sizeof(what), fmt, args);
    va_end(args);
    if (!near && otherwise)
        return lt_error(LT_EINVAL, "%s; %s", what, otherwise);
    return lt_error(LT_EINVAL, "%s; did you mean \"%s\"?", what, near ? near : list[0]);
}
