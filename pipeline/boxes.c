/* SPDX-License-Identifier: Apache-2.0 */
#include "pipeline/boxes.h"

#include "libtensor/io/file.h"
#include "libtensor/io/text/csv.h"
#include "libtensor/io/text/number.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* SHORTEST: bytes of a line with a name of one letter, four empty cells and a newline */
enum { IMAGE, SIDE, NAME, HAND, OBJECT = HAND + 4, COLUMNS = OBJECT + 4, SHORTEST = 6 };
#define MOST_BYTES ((size_t)64 << 20)
#define WANT "want image,hand_x0,hand_y0,hand_x1,hand_y1, where known also object_x0 to object_y1, object_name and side"

static const char *const columns[COLUMNS] = {
    [IMAGE] = "image", [SIDE] = "side", [NAME] = "object_name",
    [HAND] = "hand_x0", "hand_y0", "hand_x1", "hand_y1", [OBJECT] = "object_x0", "object_y0", "object_x1", "object_y1",
};

typedef struct {
    const char *path;
    int64_t line;
    int64_t cells;                  /* in each line */
    int64_t at[COLUMNS];            /* which cell of a line, from 1; 0: none */
    const char *unread;
} reader;

static char *next_cell(char **line)
{
    char *cell = lt_csv_field(line), *end;

    if (!cell)
        return NULL;
    cell += strspn(cell, " \t");
    for (end = cell + strlen(cell); end > cell && (end[-1] == ' ' || end[-1] == '\t'); )
        *--end = '\0';
    return cell;
}

/* ---- the header ------------------------------------------------------------------------------------------ */

static int find_column(const char *name)
{
    for (int c = 0; c < COLUMNS; c++)
        if (!strcmp(name, columns[c]))
            return c;
    return -1;
}

/* All of the hand's, and all or none of the object's. */
static lt_status check_columns(const reader *r)
{
    bool object = false;

    for (int c = OBJECT; c < COLUMNS; c++)
        object = object || r->at[c];
    for (int c = 0; c < COLUMNS; c++)
        if (!r->at[c] && c != SIDE && c != NAME && (c < OBJECT || object))
            return lt_error(LT_EFORMAT, "%s:1: no column %s; " WANT, r->path, columns[c]);
    return LT_OK;
}

static lt_status read_header(reader *r, char *line)
{
    for (const char *name; (name = next_cell(&line)) != NULL; ) {
        const int c = find_column(name);

        r->cells++;
        if (c >= 0 && r->at[c])
            return lt_error(LT_EFORMAT, "%s:1: two columns are called %s, want one", r->path, name);
        if (c >= 0)
            r->at[c] = r->cells;
        else if (!r->unread && *name)
            r->unread = name;
    }
    return check_columns(r);
}

/* ---- a line ---------------------------------------------------------------------------------------------- */

static lt_status split(const reader *r, char *line, const char *cell[COLUMNS])
{
    int64_t n = 0;

    for (int c = 0; c < COLUMNS; c++)
        cell[c] = "";
    for (const char *text; (text = next_cell(&line)) != NULL; ) {
        n++;
        for (int c = 0; c < COLUMNS; c++)
            if (r->at[c] == n)
                cell[c] = text;
    }
    if (n != r->cells)
        return lt_error(LT_EFORMAT, "%s:%lld: found %lld cells, the first line names %lld columns", r->path,
                        (long long)r->line, (long long)n, (long long)r->cells);
    return LT_OK;
}

static lt_status read_name(const reader *r, const char *text, const char **out)
{
    if (!*text)
        return lt_error(LT_EFORMAT, "%s:%lld: the image's name is empty", r->path, (long long)r->line);
    if (strchr(text, '/'))
        return lt_error(LT_EFORMAT, "%s:%lld: image is \"%s\", want a file's name without its folder", r->path,
                        (long long)r->line, text);
    *out = text;
    return LT_OK;
}

static lt_status read_side(const reader *r, const char *text, predict_side *out)
{
    const predict_side side = !strcasecmp(text, "left") ? PREDICT_LEFT : !strcasecmp(text, "right") ? PREDICT_RIGHT
                                                                                                    : PREDICT_ANY_SIDE;

    if (side == PREDICT_ANY_SIDE && *text)
        return lt_error(LT_EFORMAT, "%s:%lld: side is \"%s\", want left, right or nothing", r->path,
                        (long long)r->line, text);
    *out = side;
    return LT_OK;
}

/* Four cells from `first` on; *known: they are not all empty. */
static lt_status read_box(const reader *r, const char *const *cell, int first, crop_box *out, bool *known)
{
    float b[4];
    int empty = 0;

    for (int i = 0; i < 4; i++)
        empty += !*cell[first + i];
    *known = empty < 4;
    for (int i = 0; *known && i < 4; i++) {
        const char *text = cell[first + i], *end;
        const double x = lt_strtod(text, &end);

        if (end == text || *end || !(fabs(x) <= 1e6))
            return lt_error(LT_EFORMAT, "%s:%lld: %s is \"%s\", want a number of pixels%s", r->path,
                            (long long)r->line, columns[first + i], text,
                            *text ? "" : ", or nothing in all four of the box");
        b[i] = (float)x;
    }
    if (!*known)
        return LT_OK;
    if (!(b[0] < b[2] && b[1] < b[3]))
        return lt_error(LT_EFORMAT, "%s:%lld: an empty box %g,%g,%g,%g; want %s left of %s and %s above %s", r->path,
                        (long long)r->line, (double)b[0], (double)b[1], (double)b[2], (double)b[3], columns[first],
                        columns[first + 2], columns[first + 1], columns[first + 3]);
    *out = (crop_box){ b[0], b[1], b[2], b[3] };
    return LT_OK;
}

static lt_status read_row(const reader *r, char *line, predict_boxes_row *out)
{
    const char *cell[COLUMNS];
    lt_status st = split(r, line, cell);

    *out = (predict_boxes_row){ .line = r->line, .input = -1, .object_name = cell[NAME] };
    st = st ? st : read_name(r, cell[IMAGE], &out->image);
    st = st ? st : read_box(r, cell, HAND, &out->hand, &out->has_hand);
    st = st ? st : read_box(r, cell, OBJECT, &out->object, &out->has_object);
    return st ? st : read_side(r, cell[SIDE], &out->side);
}

/* ---- all lines ------------------------------------------------------------------------------------------- */

static int by_image(const void *a, const void *b)
{
    const predict_boxes_row *x = a, *y = b;
    const int order = strcmp(x->image, y->image);

    return order ? order : x->line < y->line ? -1 : x->line > y->line;
}

static lt_status read_lines(char *text, reader *r, predict_boxes *out)
{
    lt_status st = LT_OK;

    for (char *line; !st && (line = strsep(&text, "\n")) != NULL; ) {
        const size_t n = strlen(line);

        r->line++;
        if (n && line[n - 1] == '\r')
            line[n - 1] = '\0';
        if (r->line == 1)
            st = read_header(r, line);
        else if (line[strspn(line, " \t")])
            st = read_row(r, line, &out->row[out->n]), out->n += !st;
    }
    if (!st && !out->n)
        return lt_error(LT_EFORMAT, "%s:1: no lines after the names of the columns; want one for each image", r->path);
    return st;
}

/* Of lines, which may be empty, and of bytes the fewer. */
static size_t most_rows(const char *text, size_t size)
{
    size_t lines = 1;

    for (; (text = strchr(text, '\n')) != NULL; text++)
        lines++;
    return lines < size / SHORTEST + 1 ? lines : size / SHORTEST + 1;
}

/* Excel's mark that the text is UTF-8 */
static char *past_mark(char *text)
{
    return text + (strncmp(text, "\xef\xbb\xbf", 3) ? 0 : 3);
}

lt_status predict_boxes_read(lt_arena *arena, const char *path, predict_boxes *out)
{
    predict_boxes b = { .path = path };
    reader r = { .path = path };
    uint8_t *bytes;
    size_t size;
    lt_status st = lt_read_file(arena, path, MOST_BYTES, &bytes, &size);

    if (st)
        return st;
    if (memchr(bytes, 0, size))
        return lt_error(LT_EFORMAT, "%s: found a NUL byte, want text with commas", path);
    b.row = lt_arena_array(arena, most_rows((char *)bytes, size), sizeof(*b.row));
    if (!b.row)
        return lt_error(LT_ENOMEM, "%s: no memory for its lines", path);
    st = read_lines(past_mark((char *)bytes), &r, &b);
    if (st)
        return st;
    b.unread = r.unread;
    qsort(b.row, b.n, sizeof(*b.row), by_image);
    *out = b;
    return LT_OK;
}
