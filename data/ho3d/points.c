/* SPDX-License-Identifier: Apache-2.0 */
/* yajl pushes, the caller pulls: a block of text is parsed when all frames of the last one have been taken. */
#include "data/ho3d/points.h"

#include "data/ho3d/points_text.h"
#include "libtensor/base/arena.h"
#include "libtensor/geometry/hand/model.h"
#include "libtensor/io/text/number.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yajl/yajl_parse.h>

enum { BLOCK = 1 << 15, POINT_TEXT = 8, LISTS = 2, WORD_MAX = 256 };        /* a point is at least "[0,0,0]," */

/* yajl does not look at what its allocator returns, so it has memory that is there already: it gets whole words, no
 * texts and a few levels of lists, for which it takes 5 KB. */
typedef struct { max_align_t bytes[(1 << 14) / sizeof(max_align_t)]; size_t used; } pool;

struct ho3d_points {
    char *path;
    points_text *text;
    yajl_handle parser;
    pool pool;
    lt_status status;               /* sticky */
    bool at_end;                    /* of the text */
    char block[BLOCK + 1];          /* n_tail bytes of it are the beginning of a word */
    size_t n_tail;

    int points[LISTS], lists;
    bool any;                       /* ho3d_points_any */
    bool counted;                   /* points of the last list are those of its first frame */
    /* the parser's place */
    int depth, list, point, coordinate;
    int64_t frame;
    /* what is parsed and not yet taken: whole frames, then a part of one */
    float *x;
    size_t n_x, taken;
    int64_t ready[LISTS];           /* frames of each list */
    bool ended[LISTS];
    int reading;                    /* the caller's list */
};

/* ---- the parser's memory ---- */

static void *pool_alloc(void *ctx, size_t n)
{
    pool *p = ctx;
    void *out = (char *)p->bytes + p->used;

    if (n > sizeof(p->bytes) - p->used)
        return NULL;
    p->used += (n + sizeof(max_align_t) - 1) / sizeof(max_align_t) * sizeof(max_align_t);
    return out;
}

/* What lies behind the old block is copied too, and of no harm. */
static void *pool_realloc(void *ctx, void *old, size_t n)
{
    char *out = pool_alloc(ctx, n);

    if (out && old)
        memmove(out, old, n);
    return out;
}

static void pool_free(void *ctx, void *block)
{
    (void)ctx;
    (void)block;
}

/* ---- the parser's side ---- */

static int refuse(ho3d_points *p, const char *found, const char *wanted)
{
    p->status = lt_error(LT_EFORMAT, "%s: frame %lld, point %d: found %s, expected %s", p->path, (long long)p->frame,
                         p->point, found, wanted);
    return 0;
}

/* Depth below the list of frames: 0 the list, 1 a frame, 2 a point, 3 its numbers. */
static int level(const ho3d_points *p)
{
    return p->depth - (p->lists > 1);
}

static bool is_last(const ho3d_points *p)
{
    return p->list == p->lists - 1;
}

static int most_points(const ho3d_points *p)
{
    return p->any && is_last(p) && !p->counted ? HO3D_MOST_POINTS : p->points[p->list];
}

static int on_start_array(void *ctx)
{
    ho3d_points *p = ctx;
    const int at = level(p);

    p->depth++;
    if (at == 0)
        return p->list < p->lists ||
               refuse(p, "one more list", p->any ? "the end (H2O-3D's predictions have more, and are not read)"
                                                 : "the end");
    if (at == 2)
        return p->point < most_points(p) || refuse(p, "one more point", "the end of the frame");
    return at < 3 || refuse(p, "a list", "a number");
}

static int end_point(ho3d_points *p)
{
    if (p->coordinate != 3)
        return refuse(p, "the end of the point", "three numbers");
    p->coordinate = 0;
    p->point++;
    return 1;
}

static int end_frame(ho3d_points *p)
{
    char wanted[32];

    if (p->any && is_last(p) && !p->counted) {
        p->points[p->list] = p->point;
        p->counted = true;
    }
    snprintf(wanted, sizeof(wanted), "%d points", p->points[p->list]);
    if (p->point != p->points[p->list])
        return refuse(p, "the end of the frame", wanted);
    p->point = 0;
    p->frame++;
    p->ready[p->list]++;
    return 1;
}

static void end_frames(ho3d_points *p)
{
    p->ended[p->list++] = true;
    p->frame = 0;
}

static int on_end_array(void *ctx)
{
    ho3d_points *p = ctx;

    p->depth--;
    switch (level(p)) {
    case 2: return end_point(p);
    case 1: return end_frame(p);
    case 0: end_frames(p); return 1;
    default:
        while (p->any && p->list && p->list < p->lists)         /* joints alone */
            end_frames(p);
        return p->list == p->lists || refuse(p, "the end", "a list of joints and one of vertices");
    }
}

/* The first number stands one list less deep: the file is the list of joints alone. */
static void notice_joints_alone(ho3d_points *p)
{
    if (p->any && p->lists > 1 && level(p) == 2 && !p->list && !p->frame && !p->point && !p->coordinate) {
        p->lists = 1;
        p->ended[1] = true;
        p->any = false;
    }
}

static const char *place_name(const ho3d_points *p)
{
    const int n = p->points[p->list];

    return n == LT_HAND_KEYPOINTS ? "joint" : n == LT_HAND_VERTICES ? "vertex" : "point";
}

static int take_number(ho3d_points *p, double x, const char *text)
{
    notice_joints_alone(p);
    if (level(p) != 3 || p->coordinate >= 3)
        return refuse(p, "a number", "none here");
    if (!(fabs(x) < 1e4)) {
        p->status = lt_error(LT_EFORMAT, "%s: frame %lld, %s %d, %c: found %s, expected a coordinate in metres",
                             p->path, (long long)p->frame, place_name(p), p->point, "xyz"[p->coordinate], text);
        return 0;
    }
    p->x[p->n_x++] = (float)x;
    p->coordinate++;
    return 1;
}

static int on_number(void *ctx, const char *text, size_t n)
{
    char copy[WORD_MAX + 1];
    const char *end;

    if (n >= sizeof(copy))
        return refuse(ctx, "a very long number", "a coordinate in metres");
    memcpy(copy, text, n);
    copy[n] = '\0';
    return take_number(ctx, lt_strtod(copy, &end), copy);
}

static int on_null(void *ctx)
{
    ho3d_points *p = ctx;

    if (!p->any || level(p) != 0 || p->list != 1)
        return refuse(p, "null", "numbers");
    end_frames(p);
    return 1;
}

static int on_boolean(void *ctx, int b) { return refuse(ctx, b ? "true" : "false", "numbers"); }
static int on_start_map(void *ctx) { return refuse(ctx, "an object", "a list"); }

static const yajl_callbacks callbacks = {
    .yajl_null = on_null, .yajl_boolean = on_boolean, .yajl_number = on_number, .yajl_start_map = on_start_map,
    .yajl_start_array = on_start_array, .yajl_end_array = on_end_array,
};

/* ---- text ---- */

static bool is_separator(char c)
{
    return c && strchr("[]{},: \t\r\n", c);
}

/* The bytes up to the end of the last word that is followed by something. */
static size_t whole_words(const char *text, size_t n)
{
    while (n && !is_separator(text[n - 1]))
        n--;
    return n;
}

/* The word that yajl stopped in, of n bytes that it was given. */
static void word_of_error(const ho3d_points *p, size_t n, char word[WORD_MAX])
{
    const size_t consumed = yajl_get_bytes_consumed(p->parser);
    size_t from = consumed ? consumed - 1 : 0, to = from;

    while (to < n && !is_separator(p->block[to]))
        to++;
    from = whole_words(p->block, from);
    snprintf(word, WORD_MAX, "%.*s", (int)(to - from), p->block + from);
}

/* Why yajl stopped, where no callback did. NaN and infinities are no JSON, though Python writes them so. */
static lt_status verdict(ho3d_points *p, size_t n)
{
    const char *text;
    char word[WORD_MAX];

    if (p->status)
        return p->status;
    text = (const char *)yajl_get_error(p->parser, 0, NULL, 0);
    word_of_error(p, n, word);
    if (!strcmp(word, "NaN") || !strcmp(word, "Infinity") || !strcmp(word, "-Infinity"))
        take_number(p, NAN, word);
    else if (text && !strncmp(text, "lexical", 7))
        refuse(p, word, "numbers");
    else
        p->status = lt_error(LT_EFORMAT, "%s: frame %lld, point %d: %.*s", p->path, (long long)p->frame, p->point,
                             (int)strcspn(text ? text : "", "\n"), text ? text : "");
    return p->status;
}

/* n bytes of the block. A text is refused before yajl has any of it, for it would keep the whole; a word that is longer
 * than any number, too. */
static lt_status parse(ho3d_points *p, size_t n)
{
    const char *quote = memchr(p->block, '"', n);
    const size_t whole = whole_words(p->block, quote ? (size_t)(quote - p->block) : n);

    if (yajl_parse(p->parser, (const unsigned char *)p->block, whole) != yajl_status_ok)
        return verdict(p, whole);
    p->n_tail = n - whole;
    if (quote)
        refuse(p, "a text", "numbers");
    else if (p->n_tail > WORD_MAX)
        refuse(p, "a very long word", "numbers");
    memmove(p->block, p->block + whole, p->n_tail);
    return p->status;
}

static lt_status parse_block(ho3d_points *p)
{
    size_t n;

    memmove(p->x, p->x + p->taken, (p->n_x - p->taken) * sizeof(*p->x));
    p->n_x -= p->taken;
    p->taken = 0;
    p->status = points_text_read(p->text, p->block + p->n_tail, BLOCK - p->n_tail, &n);
    if (p->status)
        return p->status;
    p->at_end = !n;
    n += p->n_tail;
    if (p->at_end)
        p->block[n++] = ' ';                            /* ends the last word */
    if (!parse(p, n) && p->at_end && (yajl_complete_parse(p->parser) != yajl_status_ok || !p->ended[p->lists - 1]))
        p->status = lt_error(LT_EFORMAT, "%s: frame %lld: ends early", p->path, (long long)p->frame);
    return p->status;
}

lt_status ho3d_points_next(ho3d_points *p, float *out, bool *more)
{
    const int list = p->reading;
    size_t n;

    *more = false;
    if (list == LISTS)
        return p->status;
    while (!p->status && !p->ready[list] && !p->ended[list])
        parse_block(p);
    if (!p->status && !p->ready[list] && list >= p->lists - 1)
        while (!p->status && !p->at_end)
            parse_block(p);
    if (p->status)
        return p->status;
    if (!p->ready[list]) {
        p->reading++;
        return LT_OK;
    }
    n = 3 * (size_t)p->points[list];
    memcpy(out, p->x + p->taken, n * sizeof(*out));
    p->taken += n;
    p->ready[list]--;
    *more = true;
    return LT_OK;
}

/* ---- opening ---- */

static yajl_handle new_parser(ho3d_points *p)
{
    yajl_alloc_funcs memory = { pool_alloc, pool_realloc, pool_free, &p->pool };

    return yajl_alloc(&callbacks, &memory, p);
}

lt_status ho3d_points_open(const char *path, const int *points, int lists, ho3d_points **out)
{
    ho3d_points *p = lt_alloc(sizeof(*p));
    size_t most = BLOCK / POINT_TEXT + 1 + HO3D_MOST_POINTS;
    lt_status st;

    if (!p)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    for (int i = 0; i < lists; i++) {
        p->points[i] = points[i];
        most += (size_t)points[i];
    }
    for (int i = lists; i < LISTS; i++)
        p->ended[i] = true;
    p->lists = lists;
    p->path = strdup(path);
    p->x = lt_alloc(most * 3 * sizeof(*p->x));
    p->parser = new_parser(p);
    st = p->path && p->x && p->parser ? points_text_open(path, &p->text) : lt_error(LT_ENOMEM, "%s: no memory", path);
    if (st)
        ho3d_points_close(p);
    else
        *out = p;
    return st;
}

void ho3d_points_any(ho3d_points *p)
{
    p->any = true;
}

int ho3d_points_of(const ho3d_points *p, int list)
{
    return p->points[list];
}

const char *ho3d_points_note(const ho3d_points *p)
{
    return points_text_note(p->text);
}

void ho3d_points_close(ho3d_points *p)
{
    if (!p)
        return;
    if (p->parser)
        yajl_free(p->parser);
    points_text_close(p->text);
    lt_release(p->x);
    free(p->path);
    lt_release(p);
}
