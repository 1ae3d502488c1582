/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal: what a report's page is made of.
 */
#ifndef EVAL_REPORT_INTERNAL_H
#define EVAL_REPORT_INTERNAL_H

#include "eval/report/report.h"
#include "libtensor/base/arena.h"

#include <stdio.h>

/* html_draw_nonce - a number that nobody knew before, so that a page runs its own script and none out of a file.
 * LT_EIO */
typedef char html_nonce[33];
lt_status html_draw_nonce(html_nonce out);

/* html_begin - a page up to its heading, which is the folder's name; nonce: of its script, "": it has none */
void html_begin(FILE *f, const char *folder, const char *nonce);

/* html_text - text as text: markup and control bytes are replaced, bytes that are no UTF-8 too */
void html_text(FILE *f, const char *text);

/* html_markdown - headings, tables and paragraphs of our own table.md */
void html_markdown(FILE *f, const char *text);

/* A file of errors as palmar eval writes them: a name, then the error to sort by. */
typedef struct {
    const char *file, *title;
    int most;                       /* lines shown */
    bool histogram;                 /* of the errors as well */
} html_error_table;

/* html_errors - its worst lines, worst first; text: what is in the file, which is cut into lines. LT_ENOMEM */
lt_status html_errors(FILE *f, lt_arena *arena, const html_error_table *t, char *text);

/* html_picture, html_jpeg - a PNG, a JPEG inside the page */
void html_picture(FILE *f, const uint8_t *png, size_t n, const char *what);
void html_jpeg(FILE *f, const uint8_t *jpeg, size_t n, const char *what);

/* html_base64 - bytes as text; html_script_string - text as a string of JSON inside a script's element */
void html_base64(FILE *f, const uint8_t *bytes, size_t n);
void html_script_string(FILE *f, const char *text);

/* view_put - the view's part of the page; its script has the nonce that the page's head allows */
void view_put(FILE *f, const report_view *v, const char *nonce);

/* A curve: y over x, in the order of x */
typedef struct {
    const char *name;
    double *x, *y;
    int n;
    size_t x_room, y_room;
} report_series;

/* svg_curve - a diagram of its own, means of runs of points where there are many; a logarithmic axis where all values
 * are above 0 and the largest is 50 times the least */
void svg_curve(FILE *f, const report_series *s, const char *x_name);

/* svg_shares - several curves of numbers from 0 to 1 over numbers from 0 to 1, with their names */
void svg_shares(FILE *f, const char *name, const report_series *s, int n, const char *x_name, const char *y_name);

/* svg_histogram - how often values lie where; unit behind the numbers of the axis */
void svg_histogram(FILE *f, const char *name, const double *value, int n, const char *unit);

/* html_curves - diagrams of a detector's curves.json; path is for messages. LT_EFORMAT: it is none; LT_ENOMEM */
lt_status html_curves(FILE *f, lt_arena *arena, const char *path, const char *text, size_t n);

/* html_confusion - a detector's confusion.csv as a picture; text is cut into fields. LT_ENOMEM */
lt_status html_confusion(FILE *f, lt_arena *arena, char *text);

#endif
