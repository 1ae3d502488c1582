/* SPDX-License-Identifier: Apache-2.0 */
/* Where one picture ends and the next begins, by each format's own marks. */
#include "pipeline/pipe.h"

#include "libtensor/io/image/image.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { BLOCK = 1 << 16 };
#define MOST ((size_t)1 << 30)          /* bytes of a picture, as of a file */

struct pipe_reader {
    bool (*stop)(void);
    uint8_t *byte;                      /* n of them are read, of room */
    size_t n, room;
    bool over;
};

lt_status pipe_open(bool (*stop)(void), pipe_reader **out)
{
    pipe_reader *p = lt_alloc(sizeof(*p));

    if (!p)
        return lt_error(LT_ENOMEM, "no memory to read pictures");
    p->stop = stop;
    *out = p;
    return LT_OK;
}

void pipe_close(pipe_reader *p)
{
    if (!p)
        return;
    free(p->byte);
    lt_release(p);
}

/* ---- bytes ----------------------------------------------------------------------------------------------- */

static lt_status read_block(pipe_reader *p)
{
    ssize_t got;

    if (p->room < p->n + BLOCK) {
        const size_t room = 2 * p->room + BLOCK;
        uint8_t *more = room <= 2 * MOST ? realloc(p->byte, room) : NULL;

        if (!more)
            return lt_error(LT_ENOMEM, "no memory for a picture of %zu bytes", p->n);
        p->byte = more;
        p->room = room;
    }
    do
        got = read(STDIN_FILENO, p->byte + p->n, p->room - p->n);
    while (got < 0 && errno == EINTR && !(p->stop && p->stop()));
    if (got < 0 && errno == EINTR)
        return lt_error(LT_ESTOPPED, "predict: stopped");
    if (got < 0)
        return lt_error(lt_errno_status(errno), "standard input: %s", strerror(errno));
    p->over = got == 0;
    p->n += (size_t)got;
    return LT_OK;
}

/* Wait until n bytes are there. */
static lt_status want(pipe_reader *p, size_t n)
{
    lt_status st = n > MOST ? lt_error(LT_EFORMAT, "a picture of more than 1 GB") : LT_OK;

    while (!st && p->n < n && !p->over)
        st = read_block(p);
    if (!st && p->n < n)
        return lt_error(LT_EFORMAT, "ends within a picture, of which %zu bytes are there", p->n);
    return st;
}

static size_t big_endian(const uint8_t *byte, int n)
{
    size_t x = 0;

    for (int i = 0; i < n; i++)
        x = x << 8 | byte[i];
    return x;
}

/* ---- how long a picture is: *n bytes, which are there ----------------------------------------------------- */

/* Chunks: length, name, data, checksum. The last is IEND. */
static lt_status png_length(pipe_reader *p, size_t *n)
{
    lt_status st = LT_OK;
    bool last = false;

    for (*n = 8; !st && !last; ) {
        st = want(p, *n + 12);
        if (st)
            return st;
        last = memcmp(p->byte + *n + 4, "IEND", 4) == 0;
        *n += 12 + big_endian(p->byte + *n, 4);
    }
    return st ? st : want(p, *n);
}

/* Behind a start of scan come bytes of which FF stands before 00 or a restart mark; the next other mark ends them. */
static lt_status skip_scan(pipe_reader *p, size_t *at)
{
    for (;;) {
        const lt_status st = want(p, *at + 2);
        const uint8_t *ff = st ? NULL : memchr(p->byte + *at, 0xff, p->n - 1 - *at);

        if (st)
            return st;
        *at = ff ? (size_t)(ff - p->byte) : p->n - 1;
        if (!ff)
            continue;
        if (ff[1] != 0 && ff[1] != 0xff && (ff[1] < 0xd0 || ff[1] > 0xd7))
            return LT_OK;
        *at += ff[1] == 0xff ? 1 : 2;
    }
}

/* Segments: a mark, and but for a few the length of what follows. A second start says that this one broke off. */
static lt_status jpeg_length(pipe_reader *p, size_t *n)
{
    enum { START = 0xd8, END = 0xd9, SCAN = 0xda };
    size_t at = 2;
    uint8_t mark;

    for (;;) {
        lt_status st = want(p, at + 2);

        if (st)
            return st;
        if (p->byte[at] != 0xff)
            return lt_error(LT_EFORMAT, "a JPEG with 0x%02x at byte %zu, want a mark", p->byte[at], at);
        mark = p->byte[at + 1];
        if (mark == END || mark == START)
            break;
        at += mark == 0xff ? 1 : 2;
        if (mark == 0xff || mark == 1 || (mark >= 0xd0 && mark <= 0xd7))
            continue;
        st = want(p, at + 2);
        at += st ? 0 : big_endian(p->byte + at, 2);
        if (!st && mark == SCAN)
            st = skip_scan(p, &at);
        if (st)
            return st;
    }
    *n = mark == END ? at + 2 : at;
    return LT_OK;
}

/* A whole number of a PPM's head, behind blanks and comments, with the one blank that follows it */
static lt_status ppm_number(pipe_reader *p, size_t *at, int *out)
{
    bool comment = false;

    *out = 0;
    for (;; ++*at) {
        const lt_status st = want(p, *at + 1);
        const char c = st ? 0 : (char)p->byte[*at];

        if (st)
            return st;
        comment = comment ? c != '\n' : c == '#';
        if (!comment && !strchr(" \t\r\n", c))
            break;
    }
    for (;; ++*at) {
        const lt_status st = want(p, *at + 1);
        const char c = st ? 0 : (char)p->byte[*at];

        if (st)
            return st;
        if (c < '0' || c > '9' || *out > LT_IMAGE_MAX_SIDE)
            break;
        *out = 10 * *out + (c - '0');
    }
    return strchr(" \t\r\n", (char)p->byte[(*at)++]) ? LT_OK : lt_error(LT_EFORMAT, "a PPM whose head is no head");
}

/* P6: width, height, 255, and the pixels */
static lt_status ppm_head(pipe_reader *p, size_t *at, int size[2])
{
    int most = 0;
    lt_status st = LT_OK;

    *at = 2;
    for (int i = 0; i < 3 && !st; i++)
        st = ppm_number(p, at, i < 2 ? &size[i] : &most);
    if (st)
        return st;
    if (size[0] < 1 || size[1] < 1 || size[0] > LT_IMAGE_MAX_SIDE || size[1] > LT_IMAGE_MAX_SIDE || most != 255)
        return lt_error(LT_EFORMAT, "a PPM of %d x %d pixels up to %d, want 1 to %d and 255", size[0], size[1], most,
                        LT_IMAGE_MAX_SIDE);
    return want(p, *at + 3 * (size_t)size[0] * (size_t)size[1]);
}

/* ---- pictures -------------------------------------------------------------------------------------------- */

static lt_status decode_ppm(const pipe_reader *p, lt_arena *arena, size_t at, const int size[2], lt_image *out)
{
    lt_image img;
    const lt_status st = lt_image_init(arena, size[0], size[1], 3, 8, &img);

    if (st)
        return st;
    memcpy(img.data, p->byte + at, lt_image_bytes(&img));
    *out = img;
    return LT_OK;
}

static lt_status decode(const pipe_reader *p, lt_arena *arena, size_t n, lt_image *out)
{
    lt_image img;
    const lt_status st = lt_image_decode(arena, "a picture", p->byte, n, &img);

    return st ? st : lt_image_to_rgb8(arena, &img, out);
}

static void drop(pipe_reader *p, size_t n)
{
    memmove(p->byte, p->byte + n, p->n - n);
    p->n -= n;
}

lt_status pipe_next(pipe_reader *p, lt_arena *arena, lt_image *out, bool *more)
{
    lt_status st = LT_OK;
    size_t n = 0, at = 0;
    int size[2];

    *more = false;
    while (!st && p->n < 8 && !p->over)
        st = read_block(p);
    if (st || !p->n)
        return st;
    if (p->n >= 8 && memcmp(p->byte, "\x89PNG\r\n\x1a\n", 8) == 0)
        st = png_length(p, &n);
    else if (p->n >= 2 && memcmp(p->byte, "\xff\xd8", 2) == 0)
        st = jpeg_length(p, &n);
    else if (p->n >= 2 && memcmp(p->byte, "P6", 2) == 0)
        st = ppm_head(p, &at, size);
    else
        st = lt_error(LT_EFORMAT, "no picture begins with 0x%02x 0x%02x; want PPM (P6), PNG or JPEG one behind the "
                      "other, as of ffmpeg -f image2pipe -c:v ppm -", p->byte[0], p->n > 1 ? p->byte[1] : 0);
    if (st)
        return st;
    *more = true;
    st = at ? decode_ppm(p, arena, at, size, out) : decode(p, arena, n, out);
    drop(p, at ? at + 3 * (size_t)size[0] * (size_t)size[1] : n);
    return st;
}
