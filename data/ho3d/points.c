/* SPDX-License-Identifier: Apache-2.0 */
/* yajl pushes, the caller pulls: a block of text is parsed when all frames of the last one have been taken. */
#include "data/ho3d/points.h"

#include "libtensor/io/text/number.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <yajl/yajl_parse.h>
#include <zip.h>

enum { BLOCK = 1 << 15, POINT_TEXT = 8, LISTS = 2, WORD_MAX = 256 };        /* a point is at least "[0,0,0]," */

struct ho3d_points {
    char *path;
    FILE *file;
    zip_t *archive;
    zip_file_t *entry;
    yajl_handle parser;
    lt_status status;               /* sticky */
    bool at_end;                    /* of the text */
    size_t word;                    /* bytes of a word that the last block ended in */

    int points[LISTS], lists;
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

static int on_start_array(void *ctx)
{
    ho3d_points *p = ctx;
    const int at = level(p);

    p->depth++;
    if (at == 0)
        return p->list < p->lists || refuse(p, "one more list", "the end");
    if (at == 2)
        return p->point < p->points[p->list] || refuse(p, "one more point", "the end of the frame");
    return at < 3 || refuse(p, "a list", "a number");
}

static int on_end_array(void *ctx)
{
    ho3d_points *p = ctx;
    char wanted[32];

    p->depth--;
    switch (level(p)) {
    case 2:
        if (p->coordinate != 3)
            return refuse(p, "the end of the point", "three numbers");
        p->coordinate = 0;
        p->point++;
        return 1;
    case 1:
        if (p->point != p->points[p->list]) {
            snprintf(wanted, sizeof(wanted), "%d points", p->points[p->list]);
            return refuse(p, "the end of the frame", wanted);
        }
        p->point = 0;
        p->frame++;
        p->ready[p->list]++;
        return 1;
    case 0:
        p->ended[p->list++] = true;
        p->frame = 0;
        return 1;
    default:
        return p->list == p->lists || refuse(p, "the end", "a list of joints and one of vertices");
    }
}

static int on_number(void *ctx, const char *text, size_t n)
{
    ho3d_points *p = ctx;
    char copy[LT_NUMBER_TEXT + 32];
    const char *end;
    double x;

    if (level(p) != 3 || p->coordinate >= 3)
        return refuse(p, "a number", "none here");
    if (n >= sizeof(copy))
        return refuse(p, "a very long number", "a coordinate in metres");
    memcpy(copy, text, n);
    copy[n] = 0;
    x = lt_strtod(copy, &end);
    if (end == copy || !(fabs(x) < 1e4))
        return refuse(p, copy, "a coordinate in metres");
    p->x[p->n_x++] = (float)x;
    p->coordinate++;
    return 1;
}

static int on_null(void *ctx) { return refuse(ctx, "null", "numbers"); }
static int on_boolean(void *ctx, int b) { return refuse(ctx, b ? "true" : "false", "numbers"); }
static int on_start_map(void *ctx) { return refuse(ctx, "an object", "a list"); }

static int on_string(void *ctx, const unsigned char *s, size_t n)
{
    (void)s;
    (void)n;
    return refuse(ctx, "a text", "numbers");
}

static const yajl_callbacks callbacks = {
    .yajl_null = on_null, .yajl_boolean = on_boolean, .yajl_number = on_number, .yajl_string = on_string,
    .yajl_start_map = on_start_map, .yajl_start_array = on_start_array, .yajl_end_array = on_end_array,
};

/* What yajl made of the last bytes; its own complaint is cut to its first line. */
static lt_status verdict(ho3d_points *p, yajl_status ys)
{
    unsigned char *text;

    if (ys == yajl_status_ok || p->status)
        return p->status;
    text = yajl_get_error(p->parser, 0, NULL, 0);
    p->status = lt_error(LT_EFORMAT, "%s: frame %lld: %.*s", p->path, (long long)p->frame,
                         (int)strcspn(text ? (const char *)text : "", "\n"), text ? (const char *)text : "");
    yajl_free_error(p->parser, text);
    return p->status;
}

/* ---- text ---- */

/* The next block; 0 at the end. Errors go to the status. */
static size_t read_block(ho3d_points *p, unsigned char block[BLOCK])
{
    zip_int64_t n;

    if (!p->entry) {
        const size_t got = fread(block, 1, BLOCK, p->file);
        if (!got && ferror(p->file))
            p->status = lt_error(lt_errno_status(errno), "%s: %s", p->path, strerror(errno));
        return got;
    }
    n = zip_fread(p->entry, block, BLOCK);
    if (n < 0)
        p->status = lt_error(LT_EFORMAT, "%s: pred.json: %s", p->path, zip_file_strerror(p->entry));
    return n > 0 ? (size_t)n : 0;
}

/* How many of n bytes may be parsed: what lies before a word that is longer than any number. yajl looks at a word that
 * goes on in the next block from its start again, with every block. */
static size_t before_long_word(ho3d_points *p, const unsigned char *block, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        p->word = block[i] && strchr("[], \t\r\n", block[i]) ? 0 : p->word + 1;
        if (p->word > WORD_MAX)
            return i > WORD_MAX ? i - WORD_MAX : 0;
    }
    return n;
}

static lt_status parse_block(ho3d_points *p)
{
    unsigned char block[BLOCK];
    size_t n, short_words;

    memmove(p->x, p->x + p->taken, (p->n_x - p->taken) * sizeof(*p->x));
    p->n_x -= p->taken;
    p->taken = 0;
    n = read_block(p, block);
    if (p->status)
        return p->status;
    short_words = before_long_word(p, block, n);
    if (n && !verdict(p, yajl_parse(p->parser, block, short_words)) && short_words < n)
        refuse(p, "a very long word", "numbers");
    if (n)
        return p->status;
    p->at_end = true;
    if (verdict(p, yajl_complete_parse(p->parser)))
        return p->status;
    return p->ended[p->lists - 1] ? LT_OK : (p->status = lt_error(LT_EFORMAT, "%s: ends early", p->path));
}

lt_status ho3d_points_next(ho3d_points *p, float *out, bool *more)
{
    const int list = p->reading;
    const size_t n = 3 * (size_t)p->points[list < p->lists ? list : 0];

    *more = false;
    if (list == p->lists)
        return p->status;
    while (!p->status && !p->ready[list] && !p->ended[list])
        parse_block(p);
    if (!p->status && !p->ready[list] && list == p->lists - 1)
        while (!p->status && !p->at_end)
            parse_block(p);
    if (p->status)
        return p->status;
    if (!p->ready[list]) {
        p->reading++;
        return LT_OK;
    }
    memcpy(out, p->x + p->taken, n * sizeof(*out));
    p->taken += n;
    p->ready[list]--;
    *more = true;
    return LT_OK;
}

/* ---- opening ---- */

static lt_status open_archive(ho3d_points *p)
{
    int why = 0;

    p->archive = zip_open(p->path, ZIP_RDONLY | ZIP_CHECKCONS, &why);
    if (!p->archive)
        return lt_error(LT_EFORMAT, "%s: no zip archive, or a damaged one (libzip's error %d)", p->path, why);
    p->entry = zip_fopen(p->archive, "pred.json", 0);
    return p->entry ? LT_OK
                    : lt_error(LT_EFORMAT, "%s: %s; expected pred.json in it", p->path, zip_strerror(p->archive));
}

static lt_status open_text(ho3d_points *p)
{
    const int fd = open(p->path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat info;
    char magic[2] = { 0 };

    p->file = fd >= 0 ? fdopen(fd, "rb") : NULL;
    if (!p->file || fstat(fd, &info) != 0) {
        if (fd >= 0 && !p->file)
            close(fd);
        return lt_error(lt_errno_status(errno), "%s: %s", p->path, strerror(errno));
    }
    if (!S_ISREG(info.st_mode))
        return lt_error(LT_EIO, "%s: not a regular file", p->path);
    if (fread(magic, 1, 2, p->file) == 2 && magic[0] == 'P' && magic[1] == 'K')
        return open_archive(p);
    rewind(p->file);
    return LT_OK;
}

lt_status ho3d_points_open(const char *path, const int *points, int lists, ho3d_points **out)
{
    ho3d_points *p = calloc(1, sizeof(*p));
    size_t most = BLOCK / POINT_TEXT + 1;
    lt_status st;

    if (!p)
        return lt_error(LT_ENOMEM, "%s: no memory", path);
    for (int i = 0; i < lists; i++) {
        p->points[i] = points[i];
        most += (size_t)points[i];
    }
    p->lists = lists;
    p->path = strdup(path);
    p->x = calloc(most, 3 * sizeof(*p->x));
    p->parser = yajl_alloc(&callbacks, NULL, p);
    st = p->path && p->x && p->parser ? open_text(p) : lt_error(LT_ENOMEM, "%s: no memory", path);
    if (st)
        ho3d_points_close(p);
    else
        *out = p;
    return st;
}

void ho3d_points_close(ho3d_points *p)
{
    if (!p)
        return;
    if (p->entry)
        zip_fclose(p->entry);
    if (p->archive)
        zip_discard(p->archive);
    if (p->file)
        fclose(p->file);
    if (p->parser)
        yajl_free(p->parser);
    free(p->x);
    free(p->path);
    free(p);
}
