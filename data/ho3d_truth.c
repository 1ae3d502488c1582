/* SPDX-License-Identifier: Apache-2.0 */
/* Streams the ground-truth files of HO3D's evaluation: a gigabyte of text becomes one array. */
#include "data/ho3d.h"

#include "libtensor/io/number.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <yajl/yajl_parse.h>

/* Where the parser is: [ frame [ point [ x, y, z ], ... ], ... ] */
typedef struct {
    const char *path;
    float *out;
    int64_t n, frame;
    int points, point, coordinate, depth;
    lt_status status;
} place;

static int refuse(place *p, const char *found, const char *wanted)
{
    p->status = lt_error(LT_EFORMAT, "%s: frame %lld, point %d: found %s, expected %s", p->path,
                         (long long)p->frame, p->point, found, wanted);
    return 0;
}

static int on_start_array(void *ctx)
{
    place *p = ctx;

    switch (p->depth++) {
    case 0: return 1;
    case 1: return p->frame < p->n || refuse(p, "one more frame", "the end: evaluation.txt lists no more");
    case 2: return p->point < p->points || refuse(p, "one more point", "the end of the frame");
    default: return refuse(p, "a list", "a number");
    }
}

static int on_end_array(void *ctx)
{
    place *p = ctx;

    switch (--p->depth) {
    case 2:
        if (p->coordinate != 3)
            return refuse(p, "the end of the point", "three numbers");
        p->coordinate = 0;
        p->point++;
        return 1;
    case 1:
        if (p->point != p->points)
            return refuse(p, "the end of the frame", p->points == 21 ? "21 points" : "778 points");
        p->point = 0;
        p->frame++;
        return 1;
    default:
        return 1;
    }
}

static int on_number(void *ctx, const char *text, size_t n)
{
    place *p = ctx;
    char copy[LT_NUMBER_TEXT + 32];
    const char *end;
    double x;

    if (p->depth != 3 || p->coordinate >= 3)
        return refuse(p, "a number", "none here");
    if (n >= sizeof(copy))
        return refuse(p, "a very long number", "a coordinate in metres");
    memcpy(copy, text, n);
    copy[n] = 0;
    x = lt_strtod(copy, &end);
    if (end == copy || !(fabs(x) < 1e4))
        return refuse(p, copy, "a coordinate in metres");
    p->out[(p->frame * p->points + p->point) * 3 + p->coordinate++] = (float)x;
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
static lt_status verdict(yajl_handle y, yajl_status ys, place *p)
{
    unsigned char *text;

    if (ys == yajl_status_ok || p->status)
        return p->status;
    text = yajl_get_error(y, 0, NULL, 0);
    p->status = lt_error(LT_EFORMAT, "%s: frame %lld: %.*s", p->path, (long long)p->frame,
                         (int)strcspn(text ? (const char *)text : "", "\n"), text ? (const char *)text : "");
    yajl_free_error(y, text);
    return p->status;
}

static lt_status stream(FILE *f, yajl_handle y, place *p)
{
    unsigned char block[65536];
    size_t n;

    while ((n = fread(block, 1, sizeof(block), f)) > 0)
        if (verdict(y, yajl_parse(y, block, n), p))
            return p->status;
    if (ferror(f))
        return lt_error(LT_EIO, "%s: %s", p->path, strerror(errno));
    if (verdict(y, yajl_complete_parse(y), p))
        return p->status;
    if (p->frame != p->n)
        return lt_error(LT_EFORMAT, "%s: has %lld frames, evaluation.txt lists %lld", p->path,
                        (long long)p->frame, (long long)p->n);
    return LT_OK;
}

lt_status ho3d_read_truth(lt_arena *arena, const char *path, int64_t n, int points, float **out)
{
    place p = { .path = path, .n = n, .points = points };
    FILE *f = fopen(path, "rb");
    yajl_handle y = NULL;
    lt_status st;

    if (!f)
        return lt_error(LT_EIO, "%s: %s", path, strerror(errno));
    st = lt_arena_try(arena, (size_t)n * (size_t)points * 3 * sizeof(float), (void **)&p.out);
    if (st)
        goto done;
    y = yajl_alloc(&callbacks, NULL, &p);
    st = y ? stream(f, y, &p) : lt_error(LT_ENOMEM, "%s: no memory", path);
    if (!st)
        *out = p.out;
done:
    if (y)
        yajl_free(y);
    fclose(f);
    return st;
}
