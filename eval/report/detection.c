/* SPDX-License-Identifier: Apache-2.0 */
/* What a detector's scores left: precision over recall, and what is taken for what. */
#include "eval/report/internal.h"

#include "libtensor/io/text/csv.h"
#include "libtensor/io/text/json.h"
#include "libtensor/io/text/number.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

/* ---- curves ------------------------------------------------------------------------------------------------- */

enum { MOST_GROUPS = 8 };

/* A curve of the file: its numbers over the recalls 0 .. 1. False: there is none */
static bool read_curve(lt_arena *arena, const cJSON *item, report_series *out)
{
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(item, "name"), *v;
    const cJSON *precision = cJSON_GetObjectItemCaseSensitive(item, "precision");
    const int n = cJSON_GetArraySize(precision);
    double sum = 0;

    if (!cJSON_IsString(name) || n < 2)
        return false;
    *out = (report_series){ .x = lt_arena_array(arena, (size_t)n, sizeof(*out->x)),
                            .y = lt_arena_array(arena, (size_t)n, sizeof(*out->y)) };
    cJSON_ArrayForEach(v, precision) {
        if (!out->x || !out->y || !cJSON_IsNumber(v) || !(v->valuedouble >= 0 && v->valuedouble <= 1))
            return false;
        out->x[out->n] = (double)out->n / (n - 1);
        out->y[out->n++] = v->valuedouble;
        sum += v->valuedouble;
    }
    out->name = lt_arena_printf(arena, "%s %.3f", name->valuestring, sum / n);
    return out->name;
}

/* All that are of one IoU as one diagram */
static void put_diagram(FILE *f, lt_arena *arena, const cJSON *list, double iou)
{
    report_series of[MOST_GROUPS];
    const cJSON *item;
    char title[64];
    int n = 0;

    cJSON_ArrayForEach(item, list) {
        const cJSON *at = cJSON_GetObjectItemCaseSensitive(item, "iou");

        if (n < MOST_GROUPS && cJSON_IsNumber(at) && at->valuedouble == iou)
            n += read_curve(arena, item, &of[n]);
    }
    snprintf(title, sizeof(title), "Boxes at IoU %.2f", iou);
    if (n)
        svg_shares(f, title, of, n, "recall", "precision");
}

lt_status html_curves(FILE *f, lt_arena *arena, const char *path, const char *text, size_t n)
{
    cJSON *list;
    const lt_status st = lt_json_parse(path, text, n, &list);

    if (st)
        return st;
    fputs("<h2>Precision over recall</h2>\n", f);
    put_diagram(f, arena, list, 0.5);
    put_diagram(f, arena, list, 0.75);
    cJSON_Delete(list);
    return LT_OK;
}

/* ---- confusion ---------------------------------------------------------------------------------------------- */

/* The fields of a line, which is cut into them */
static int fields(char *line, const char **out, int most)
{
    int n = 0;

    for (char *part; n < most && (part = lt_csv_field(&line)); )
        out[n++] = part;
    return n;
}

typedef struct {
    const char **column, **row;     /* names */
    int columns, rows;
    double *count;                  /* (rows, columns) */
} confusion;

enum { MOST_NAMES = 1024 };

static lt_status take_row(lt_arena *arena, char *line, confusion *c)
{
    const char **part = lt_arena_array(arena, (size_t)c->columns + 2, sizeof(*part));

    if (!part)
        return lt_error(LT_ENOMEM, "no memory for a table");
    if (fields(line, part, c->columns + 2) != c->columns + 1)
        return LT_OK;                               /* a line cut short is left out */
    for (int k = 0; k < c->columns; k++) {
        const char *end;
        const double x = lt_strtod(part[k + 1], &end);

        c->count[c->rows * c->columns + k] = isfinite(x) && x > 0 && x < 1e9 ? x : 0;
    }
    c->row[c->rows++] = part[0];
    return LT_OK;
}

static lt_status read_confusion(lt_arena *arena, char *text, confusion *c)
{
    char *line = strsep(&text, "\n");
    const char **head = lt_arena_array(arena, MOST_NAMES + 1, sizeof(*head));
    lt_status st = LT_OK;

    *c = (confusion){ .row = lt_arena_array(arena, MOST_NAMES, sizeof(*c->row)) };
    if (!head || !c->row)
        return lt_error(LT_ENOMEM, "no memory for a table");
    c->columns = (int)lt_max_i64(0, fields(line, head, MOST_NAMES + 1) - 1);
    c->column = head + 1;
    c->count = lt_arena_array(arena, (size_t)c->columns * MOST_NAMES, sizeof(*c->count));
    if (!c->count)
        return lt_error(LT_ENOMEM, "no memory for a table");
    while (!st && c->rows < MOST_NAMES && (line = strsep(&text, "\n")) != NULL)
        st = *line ? take_row(arena, line, c) : LT_OK;
    return st;
}

static double row_sum(const confusion *c, int r)
{
    double sum = 0;

    for (int k = 0; k < c->columns; k++)
        sum += c->count[r * c->columns + k];
    return sum;
}

/* Each row in shares of itself: right on the diagonal, blue; elsewhere what is wrong, red */
static void put_cells(FILE *f, const confusion *c, double side, double left, double top)
{
    for (int r = 0; r < c->rows; r++)
        for (int k = 0; k < c->columns; k++) {
            const double n = c->count[r * c->columns + k], share = n > 0 ? n / row_sum(c, r) : 0;
            const bool right = strcmp(c->row[r], c->column[k]) == 0;

            if (n <= 0)
                continue;
            fprintf(f, "<rect x=%.1f y=%.1f width=%.1f height=%.1f fill-opacity=%.3f style=\"fill:%s\"><title>",
                    left + k * side, top + r * side, side, side, 0.08 + 0.92 * share, right ? "#1d4ed8" : "#b91c1c");
            html_text(f, c->row[r]);
            fputs(" found as ", f);
            html_text(f, c->column[k]);
            fprintf(f, ": %.0f of %.0f</title></rect>\n", n, row_sum(c, r));
            if (side > 14)
                fprintf(f, "<text x=%.1f y=%.1f text-anchor=middle style=\"font-size:8px%s\">%.0f</text>\n",
                        left + (k + 0.5) * side, top + (r + 0.5) * side + 3, share > 0.45 ? ";fill:#fff" : "", n);
        }
}

static void put_names(FILE *f, const confusion *c, double side, double left, double top)
{
    for (int r = 0; r < c->rows; r++) {
        fprintf(f, "<text x=%.1f y=%.1f text-anchor=end>", left - 4, top + (r + 0.5) * side + 3);
        html_text(f, c->row[r]);
        fputs("</text>\n", f);
    }
    for (int k = 0; k < c->columns; k++) {
        const double x = left + (k + 0.5) * side + 3, y = top - 4;

        fprintf(f, "<text x=%.1f y=%.1f transform=\"rotate(-60 %.1f %.1f)\">", x, y, x, y);
        html_text(f, c->column[k]);
        fputs("</text>\n", f);
    }
}

lt_status html_confusion(FILE *f, lt_arena *arena, char *text)
{
    const double left = 150, top = 130, right = 80;
    confusion c;
    const lt_status st = read_confusion(arena, text, &c);
    const double side = c.columns > 40 ? 10 : 20;

    if (st || !c.rows || !c.columns)
        return st;
    fputs("<h2>What is taken for what</h2>\n<p>A row is what is there, a column what was found; a row's colours are "
          "shares of it. Scores above 0.25, boxes at IoU 0.5.</p>\n<div class=wide>", f);
    fprintf(f, "<svg viewBox=\"0 0 %.0f %.0f\" width=%.0f height=%.0f role=img>\n", left + side * c.columns + right,
            top + side * c.rows + 8, left + side * c.columns + right, top + side * c.rows + 8);
    fprintf(f, "<path class=a d=\"M%.0f %.0fh%.0fv%.0fh-%.0fz\"/>\n", left, top, side * c.columns, side * c.rows,
            side * c.columns);
    put_cells(f, &c, side, left, top);
    put_names(f, &c, side, left, top);
    fputs("</svg></div>\n", f);
    return LT_OK;
}
