/* SPDX-License-Identifier: Apache-2.0 */
/* Files of errors as tables of their worst lines. */
#include "eval/report/internal.h"
#include "libtensor/io/text/csv.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    const char *line;               /* of a file of errors, its name first */
    double error_mm;
} entry;

static int by_error(const void *a, const void *b)
{
    const double x = ((const entry *)a)->error_mm, y = ((const entry *)b)->error_mm;

    return (y > x) - (y < x);
}

/* The second field of a line, NaN where it is no number */
static double error_of(lt_arena *arena, const char *line)
{
    char *rest = lt_arena_strdup(arena, line), *end = NULL, *number;
    double x;

    lt_csv_field(&rest);
    number = lt_csv_field(&rest);
    x = number ? strtod(number, &end) : NAN;
    return number && end > number ? x : NAN;
}

/* Lines behind the heading whose second field is a number; text is cut into lines */
static entry *take_entries(lt_arena *arena, char *text, int *n)
{
    int lines = 0;
    entry *list;

    for (const char *c = text; *c; c++)
        lines += *c == '\n';
    list = lt_arena_array(arena, (size_t)lines + 1, sizeof(*list));
    *n = 0;
    strtok(text, "\n");
    for (char *line; list && (line = strtok(NULL, "\n")); ) {
        list[*n] = (entry){ line, error_of(arena, line) };
        *n += isfinite(list[*n].error_mm);
    }
    return list;
}

static void put_cells(FILE *f, lt_arena *arena, const char *line, const char *cell)
{
    char *copy = lt_arena_strdup(arena, line);

    fputs("<tr>", f);
    for (char *part; (part = lt_csv_field(&copy)); ) {
        fprintf(f, "<%s>", cell);
        html_text(f, part);
        fprintf(f, "</%s>", cell);
    }
    fputs("</tr>\n", f);
}

static lt_status put_histogram(FILE *f, lt_arena *arena, const entry *list, int n)
{
    double *errors = lt_arena_array(arena, (size_t)n + 1, sizeof(*errors));

    if (!errors)
        return lt_error(LT_ENOMEM, "no memory for the samples");
    for (int i = 0; i < n; i++)
        errors[i] = list[i].error_mm;
    if (n)
        svg_histogram(f, "PA-MPJPE of the samples", errors, n, "mm");
    return LT_OK;
}

lt_status html_errors(FILE *f, lt_arena *arena, const html_error_table *t, char *text)
{
    const char *heading = lt_arena_printf(arena, "%.*s", (int)strcspn(text, "\n"), text);
    int n;
    entry *list = take_entries(arena, text, &n);
    lt_status st = LT_OK;

    if (!heading || !list)
        return lt_error(LT_ENOMEM, "no memory for %s", t->file);
    fprintf(f, "<h2>%s</h2>\n", t->title);
    if (t->histogram)
        st = put_histogram(f, arena, list, n);
    qsort(list, (size_t)n, sizeof(*list), by_error);
    fprintf(f, "<h3>The %d worst of %d</h3>\n<div class=wide><table>\n", n < t->most ? n : t->most, n);
    put_cells(f, arena, heading, "th");
    for (int i = 0; i < n && i < t->most; i++)
        put_cells(f, arena, list[i].line, "td");
    fputs("</table></div>\n", f);
    return st;
}
