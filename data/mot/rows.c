/* SPDX-License-Identifier: Apache-2.0 */
/* The rows of gt.txt, det.txt and files of results. */
#include "data/mot/mot.h"

#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "libtensor/io/text/lines.h"
#include "libtensor/io/text/number.h"

#include <math.h>
#include <string.h>

enum { COLUMNS = 10, FRAME = 0, ID, LEFT, TOP, WIDTH, HEIGHT, SCORE, CLASS, VISIBLE };

static const double WHOLE = 9007199254740992;   /* whole numbers up to here are exact */

static const struct { const char *what; int least, most; } kinds[] = {
    [MOT_TRUTH] = { "the truth", 9, 10 },
    [MOT_DETECTIONS] = { "detections", 7, 10 },
    [MOT_RESULTS] = { "results", 6, 10 },
};

/* A row and the frame that it is in */
typedef struct { int64_t frame; mot_box box; } placed;

typedef struct {
    lt_arena *arena;
    const char *path;
    mot_kind kind;
    int64_t frames;
    size_t line;
    double column[COLUMNS];
    int n;
} row;

static lt_status take(row *r, const char *text)
{
    r->n = 0;
    for (;;) {
        const char *end, *at = lt_skip_blanks(text);
        const double v = lt_strtod(at, &end);

        if (r->n == COLUMNS)
            return lt_error(LT_EFORMAT, "%s:%zu: more than %d columns", r->path, r->line, (int)COLUMNS);
        if (end == at || !isfinite(v))
            return lt_error(LT_EFORMAT, "%s:%zu: \"%.20s\" is no number", r->path, r->line, at);
        r->column[r->n++] = v;
        text = lt_skip_blanks(end);
        if (!*text)
            return LT_OK;
        if (*text++ != ',')
            return lt_error(LT_EFORMAT, "%s:%zu: \"%.20s\", expected a comma", r->path, r->line, text - 1);
    }
}

static lt_status check_whole(const row *r, int column, const char *what, double lo, double hi)
{
    const double v = r->column[column];

    if (v >= lo && v <= hi && v == floor(v))
        return LT_OK;
    return lt_error(LT_EFORMAT, "%s:%zu: %s %.15g, expected a whole number from %.15g to %.15g", r->path, r->line, what,
                    v, lo, hi);
}

static lt_status check(const row *r)
{
    const int least = kinds[r->kind].least;
    lt_status st;

    if (r->n < least)
        return lt_error(LT_EFORMAT, "%s:%zu: %d columns, expected %d of %s", r->path, r->line, r->n, least,
                        kinds[r->kind].what);
    st = check_whole(r, FRAME, "frame", 1, (double)r->frames);
    if (!st)
        st = check_whole(r, ID, "id", -WHOLE, WHOLE);
    if (!st && r->kind == MOT_TRUTH && r->n == 9)
        st = check_whole(r, CLASS, "class", 1, MOT_CLASSES);
    for (int k = LEFT; !st && k <= HEIGHT; k++)
        if (fabs(r->column[k]) > 1e9)
            st = lt_error(LT_EFORMAT, "%s:%zu: %g, expected pixels", r->path, r->line, r->column[k]);
    return st;
}

static mot_box box_of(const row *r)
{
    const double x = r->column[LEFT] - 1, y = r->column[TOP] - 1;
    const bool truth = r->kind == MOT_TRUTH, classes = truth && r->n == 9;

    return (mot_box){
        .id = (int64_t)r->column[ID], .box = { x, y, x + r->column[WIDTH], y + r->column[HEIGHT] },
        .score = truth || r->n <= SCORE ? 1 : r->column[SCORE], .scored = !truth || r->column[SCORE] != 0,
        .cls = classes ? (int)r->column[CLASS] : MOT_PEDESTRIAN, .visible = classes ? r->column[VISIBLE] : 1,
    };
}

/* In the order of frames, and of the file within one */
static lt_status sort_rows(const row *r, const placed *list, size_t n, mot_frame **out)
{
    mot_frame *frame = lt_arena_array(r->arena, (size_t)r->frames + 1, sizeof(*frame));
    mot_box *box = lt_arena_array(r->arena, n + 1, sizeof(*box));
    size_t *at = lt_arena_array(r->arena, (size_t)r->frames + 1, sizeof(*at));

    if (!frame || !box || !at)
        return lt_error(LT_ENOMEM, "%s: no memory", r->path);
    for (size_t i = 0; i < n; i++)
        at[list[i].frame + 1]++;
    for (int64_t k = 0; k < r->frames; k++) {
        frame[k] = (mot_frame){ box + at[k], (int)at[k + 1] };
        at[k + 1] += at[k];
    }
    for (size_t i = 0; i < n; i++)
        box[at[list[i].frame]++] = list[i].box;
    *out = frame;
    return LT_OK;
}

lt_status mot_parse(lt_arena *arena, const char *path, char *text, size_t n, mot_kind kind, int64_t frames,
                    mot_frame **out)
{
    row r = { .arena = arena, .path = path, .kind = kind, .frames = frames };
    size_t rows = 0, room = 0;
    placed *list = NULL;
    lt_text_lines lines;

    if (memchr(text, 0, n))
        return lt_error(LT_EFORMAT, "%s: has a NUL character: no file of boxes", path);
    lines = lt_lines_of(text, n);
    for (const char *line = lt_next_line(&lines); line; line = lt_next_line(&lines)) {
        lt_status st;

        r.line = lines.number;
        if (!*lt_skip_blanks(line))
            continue;
        st = take(&r, line);
        if (!st)
            st = check(&r);
        if (st)
            return st;
        list = lt_arena_grow(arena, list, rows, &room, sizeof(*list));
        if (!list)
            return lt_error(LT_ENOMEM, "%s: no memory", path);
        list[rows++] = (placed){ (int64_t)r.column[FRAME] - 1, box_of(&r) };
    }
    return sort_rows(&r, list, rows, out);
}

lt_status mot_read(lt_arena *arena, const char *path, mot_kind kind, int64_t frames, mot_frame **out)
{
    lt_file f;
    lt_status st = lt_file_load(&f, path, LT_FILE_MAX);

    if (!st)
        st = mot_parse(arena, path, (char *)f.bytes, f.n, kind, frames, out);
    lt_file_free(&f);
    return st;
}

lt_status mot_write(const char *path, const mot_frame *frame, int64_t frames)
{
    lt_atomic_file f;
    lt_status st = lt_atomic_open(&f, path);

    if (st)
        return st;
    for (int64_t k = 0; k < frames; k++)
        for (int i = 0; i < frame[k].n; i++) {
            const mot_box *b = &frame[k].box[i];

            fprintf(f.stream, "%lld,%lld,%.2f,%.2f,%.2f,%.2f,%.4f,-1,-1,-1\n", (long long)k + 1, (long long)b->id,
                    b->box[0] + 1, b->box[1] + 1, b->box[2] - b->box[0], b->box[3] - b->box[1], b->score);
        }
    return lt_atomic_commit(&f);
}
