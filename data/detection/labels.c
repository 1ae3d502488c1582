/* SPDX-License-Identifier: Apache-2.0 */
/* The rows of YOLO's files of labels: a box or a polygon each, in shares of the image. */
#include "data/detection/internal.h"

#include "libtensor/io/text/lines.h"
#include "libtensor/io/text/number.h"

#include <math.h>
#include <string.h>

static const double SLACK = 0.01;       /* beyond the image, as rounding and cropping leave it */
enum { BOX_NUMBERS = 5, LEAST_NUMBERS = 7, MAX_NUMBERS = 20001 };

typedef struct {
    lt_arena *arena;
    const char *path;
    size_t line;
    int classes;
    float *number;
    int n;
} row;

/* All numbers of a line, which live as long as the arena */
static lt_status take(row *r, const char *text)
{
    r->n = 0;
    r->number = lt_arena_array(r->arena, strlen(text) / 2 + 1, sizeof(*r->number));
    if (!r->number)
        return lt_error(LT_ENOMEM, "%s: no memory", r->path);
    for (text = lt_skip_blanks(text); *text; text = lt_skip_blanks(text)) {
        const char *end;
        const double v = lt_strtod(text, &end);

        if (end == text || (*end && !strchr(" \t\r", *end)) || !isfinite(v))
            return lt_error(LT_EFORMAT, "%s:%zu: \"%.20s\" is no number", r->path, r->line, text);
        if (r->n == MAX_NUMBERS)
            return lt_error(LT_EFORMAT, "%s:%zu: more than %d numbers", r->path, r->line, (int)MAX_NUMBERS);
        r->number[r->n++] = (float)v;
        text = end;
    }
    return LT_OK;
}

static lt_status check(const row *r)
{
    if (r->n == BOX_NUMBERS + 1)
        return lt_error(LT_EFORMAT, "%s:%zu: 6 numbers: results with a score, not labels", r->path, r->line);
    if (r->n != BOX_NUMBERS && (r->n < LEAST_NUMBERS || r->n % 2 == 0))
        return lt_error(LT_EFORMAT, "%s:%zu: %d numbers, want 5 of a box, or a class and x y of three corners and more",
                        r->path, r->line, r->n);
    if (!(r->number[0] >= 0 && r->number[0] < (float)r->classes) || r->number[0] != floorf(r->number[0]))
        return lt_error(LT_EFORMAT, "%s:%zu: class %g, want a whole number from 0 to %d", r->path, r->line,
                        (double)r->number[0], r->classes - 1);
    for (int i = 1; i < r->n; i++)
        if (!((double)r->number[i] >= -SLACK && (double)r->number[i] <= 1 + SLACK))
            return lt_error(LT_EFORMAT, "%s:%zu: %g, want shares of width and height from 0 to 1%s", r->path, r->line,
                            (double)r->number[i], r->number[i] > 1.5f ? ", not pixels" : "");
    return LT_OK;
}

static void box_of_extent(const float *point, int corners, float box[4])
{
    for (int k = 0; k < 2; k++) {
        box[k] = box[k + 2] = point[k];
        for (int i = 1; i < corners; i++) {
            box[k] = fminf(box[k], point[2 * i + k]);
            box[k + 2] = fmaxf(box[k + 2], point[2 * i + k]);
        }
    }
}

static lt_status object_of(const row *r, detection_object *o)
{
    const int corners = (r->n - 1) / 2;
    int *count;

    *o = (detection_object){ .cls = (int)r->number[0], .border = true };
    if (r->n == BOX_NUMBERS) {
        for (int k = 0; k < 2; k++) {
            o->box[k] = r->number[1 + k] - r->number[3 + k] / 2;
            o->box[k + 2] = r->number[1 + k] + r->number[3 + k] / 2;
        }
        return LT_OK;
    }
    count = lt_arena_array(r->arena, 1, sizeof(*count));
    if (!count)
        return lt_error(LT_ENOMEM, "%s: no memory", r->path);
    *count = corners;
    o->mask = DETECTION_POLYGONS;
    o->point = r->number + 1;
    box_of_extent(o->point, corners, o->box);
    o->corners = count;
    o->n_polygons = 1;
    return LT_OK;
}

static bool same(const detection_object *a, const detection_object *b)
{
    if (a->cls != b->cls || memcmp(a->box, b->box, sizeof(a->box)) || a->n_polygons != b->n_polygons)
        return false;
    return !a->n_polygons || (a->corners[0] == b->corners[0] &&
                              !memcmp(a->point, b->point, (size_t)a->corners[0] * 2 * sizeof(*a->point)));
}

static lt_status add(const row *r, const detection_object *o, object_list *out, int64_t *twice)
{
    for (size_t i = 0; i < out->n; i++)
        if (same(&out->list[i], o)) {
            ++*twice;
            return LT_OK;
        }
    out->list = lt_arena_grow(r->arena, out->list, out->n, &out->room, sizeof(*out->list));
    if (!out->list)
        return lt_error(LT_ENOMEM, "%s: no memory", r->path);
    out->list[out->n++] = *o;
    return LT_OK;
}

lt_status detection_parse_labels(lt_arena *arena, const char *path, char *text, size_t n, int classes,
                                 object_list *out, int64_t *twice)
{
    row r = { .arena = arena, .path = path, .classes = classes };
    lt_text_lines lines;
    lt_status st = LT_OK;

    if (memchr(text, 0, n))
        return lt_error(LT_EFORMAT, "%s: has a NUL character: no file of labels", path);
    lines = lt_lines_of(text, n);
    for (const char *line = lt_next_line(&lines); line && st == LT_OK; line = lt_next_line(&lines)) {
        detection_object o;

        r.line = lines.number;
        if (!*lt_skip_blanks(line))
            continue;
        st = take(&r, line);
        if (st == LT_OK)
            st = check(&r);
        if (st == LT_OK)
            st = object_of(&r, &o);
        if (st == LT_OK)
            st = add(&r, &o, out, twice);
    }
    return st;
}
