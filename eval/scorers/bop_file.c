/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/scorers/bop_file.h"

#include "eval/scorers/results_file.h"
#include "libtensor/io/text/lines.h"
#include "libtensor/io/text/number.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* SHORTEST: bytes of a line whose numbers have a digit each */
enum { FIELDS = 17, SHORTEST = 2 * FIELDS - 1 };

static const char header[] = "scene_id,im_id,obj_id,score,R,t,time";

/* By target, the best score first. */
static int by_target(const void *a, const void *b)
{
    const bop_estimate *x = a, *y = b;

    if (x->scene != y->scene)
        return x->scene < y->scene ? -1 : 1;
    if (x->image != y->image)
        return x->image < y->image ? -1 : 1;
    if (x->object != y->object)
        return x->object < y->object ? -1 : 1;
    return x->score > y->score ? -1 : x->score < y->score;
}

/* The fields of a line, and how many numbers each has. */
static const struct { const char *name; int n; } field[] = {
    { "scene_id", 1 }, { "im_id", 1 }, { "obj_id", 1 }, { "score", 1 }, { "R", 9 }, { "t", 3 }, { "time", 1 },
};

static bool whole(double x)
{
    return x == floor(x) && fabs(x) < 1e9;
}

/* n numbers with blanks between them and around */
static bool parse_field(const char **text, double *x, int n)
{
    for (int i = 0; i < n; i++) {
        const char *from = lt_skip_blanks(*text);
        x[i] = lt_strtod(from, text);
        if (*text == from || (i + 1 < n && lt_skip_blanks(*text) == *text))
            return false;
    }
    *text = lt_skip_blanks(*text);
    return true;
}

/* The name of the field that is wrong; NULL: none is. */
static const char *parse_fields(const char *text, double x[FIELDS])
{
    const size_t last = LT_COUNT(field) - 1;
    int at = 0;

    for (size_t i = 0; i <= last; i++) {
        if (!parse_field(&text, x + at, field[i].n) || *text != (i < last ? ',' : '\0') ||
            (i < 3 && !whole(x[at])) || (i == 3 && !isfinite(x[at])))
            return field[i].name;
        text += i < last;
        at += field[i].n;
    }
    return NULL;
}

static lt_status parse_line(const char *path, int64_t number, const char *text, void *row)
{
    bop_estimate *out = row;
    double x[FIELDS];
    const char *wrong = parse_fields(text, x);

    if (wrong)
        return lt_error(LT_EFORMAT, "%s:%lld: expected %s, with 9 numbers for R and 3 for t; %s is not as it should be",
                        path, (long long)number, header, wrong);
    *out = (bop_estimate){ (int)x[0], (int)x[1], (int)x[2], x[3], { { 0 }, { x[13], x[14], x[15] } }, number };
    memcpy(out->pose.R, x + 4, sizeof(out->pose.R));
    return LT_OK;
}

static const results_format format = {
    .header = header, .shortest = SHORTEST, .row_size = sizeof(bop_estimate), .parse = parse_line, .order = by_target,
};

lt_status bop_file_read(lt_arena *arena, const char *path, bop_file *out)
{
    void *rows;
    const lt_status st = results_file_read(arena, path, &format, &rows, &out->n);

    if (st == LT_OK)
        out->estimate = rows;
    return st;
}

const bop_estimate *bop_file_find(const bop_file *file, int scene, int image, int object)
{
    const bop_estimate key = { .scene = scene, .image = image, .object = object, .score = INFINITY };
    int64_t lo = 0, hi = file->n;

    while (lo < hi) {
        const int64_t middle = (lo + hi) / 2;
        if (by_target(&file->estimate[middle], &key) < 0)
            lo = middle + 1;
        else
            hi = middle;
    }
    if (lo == file->n || file->estimate[lo].scene != scene || file->estimate[lo].image != image
        || file->estimate[lo].object != object)
        return NULL;
    return &file->estimate[lo];
}
