/* SPDX-License-Identifier: Apache-2.0 */
/* Names and numbers, with quotes where a name needs them. */
#include "libtensor/io/text/csv.h"

#include "libtensor/base/printable.h"
#include "libtensor/io/text/number.h"
#include "libtensor/io/text/utf8.h"

#include <math.h>
#include <string.h>

/* Of a character that could steer a terminal, but for the end of a line, a '?' is left. */
static void put_character(FILE *f, uint32_t code)
{
    char utf8[LT_UTF8_MAX];

    if (code == '"')
        fputc('"', f);
    if (lt_is_control(code) && code != '\n')
        fputc('?', f);
    else
        fwrite(utf8, 1, lt_utf8_put(utf8, code), f);
}

static void put_field(FILE *f, const char *text)
{
    const bool quoted = text[strcspn(text, ",\"\r\n")];
    const char *end = text + strlen(text);

    if (quoted)
        fputc('"', f);
    while (text < end)
        put_character(f, lt_utf8_next(&text, end));
    if (quoted)
        fputc('"', f);
}

lt_status lt_csv_open(lt_csv *w, const char *path, const char *about, int n_metrics, const char *const *metric)
{
    const lt_status st = lt_atomic_open(&w->file, path);

    if (st)
        return st;
    w->n_metrics = n_metrics;
    put_field(w->file.stream, about);
    for (int i = 0; i < n_metrics; i++) {
        fputc(',', w->file.stream);
        put_field(w->file.stream, metric[i]);
    }
    fputc('\n', w->file.stream);
    return LT_OK;
}

static void put_value(FILE *f, double x)
{
    char text[LT_NUMBER_TEXT];

    fputc(',', f);
    if (isinf(x))
        fputs(x > 0 ? "inf" : "-inf", f);
    else if (!isnan(x))
        fputs(lt_print_float((float)x, text), f);
}

void lt_csv_add(lt_csv *w, const char *name, const double *value)
{
    put_field(w->file.stream, name);
    for (int i = 0; i < w->n_metrics; i++)
        put_value(w->file.stream, value[i]);
    fputc('\n', w->file.stream);
}

lt_status lt_csv_commit(lt_csv *w)
{
    return lt_atomic_commit(&w->file);
}

char *lt_csv_field(char **line)
{
    char *const field = *line, *to = field, *from = field;
    bool quoted = false;

    if (!field)
        return NULL;
    for (; *from && (quoted || *from != ','); from++) {
        const bool twice = quoted && from[0] == '"' && from[1] == '"';

        if (*from == '"' && !twice)
            quoted = !quoted;
        else
            *to++ = *(from += twice);
    }
    *line = *from ? from + 1 : NULL;
    *to = '\0';
    return field;
}
