/* SPDX-License-Identifier: Apache-2.0 */
/* Heads of films. Both kinds of file nest parts in parts, and each part says how long it is. */
#include "libtensor/io/image/film_head.h"

#include "libtensor/io/kind.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

enum { MOST_PARTS = 1 << 16 };          /* in one part: a film has a few dozen, or as many as it has fragments */

typedef struct {
    FILE *f;
    int64_t size;
} source;

/* Of the file: its contents are from `at` to before `end`. */
typedef struct {
    uint32_t id;
    int64_t at, end;
} part;

/* Reads the head of the part at p->at; false where there is none. */
typedef bool read_part(const source *s, part *p);

static bool read_bytes(const source *s, int64_t at, uint8_t *out, size_t n)
{
    return at >= 0 && at <= s->size - (int64_t)n && fseeko(s->f, at, SEEK_SET) == 0 && fread(out, 1, n, s->f) == n;
}

static uint64_t big_endian(const uint8_t *b, size_t n)
{
    uint64_t v = 0;

    for (size_t i = 0; i < n; i++)
        v = v << 8 | b[i];
    return v;
}

/* The next part in `in`, where *p is the one before it or {0} at first; one that ends behind `in` is cut there. */
static bool next_part(const source *s, read_part *read, const part *in, part *p)
{
    part next = { .at = p->end ? p->end : in->at };

    if (next.at >= in->end || !read(s, &next) || next.at > in->end)
        return false;
    if (next.end > in->end)
        next.end = in->end;
    *p = next;
    return true;
}

static bool find_part(const source *s, read_part *read, const part *in, uint32_t id, part *out)
{
    part p = { 0 };

    for (int i = 0; i < MOST_PARTS && next_part(s, read, in, &p); i++)
        if (p.id == id) {
            *out = p;
            return true;
        }
    return false;
}

/* A frame's x right and y down as they are shown: x' = a x + c y, y' = b x + d y. Nearly a quarter turn is one, and the
 * sizes of pixels do not matter. */
static int orientation_of(double a, double b, double c, double d)
{
    static const int straight[2][2] = { { 1, 4 }, { 2, 3 } }, across[2][2] = { { 5, 6 }, { 8, 7 } };

    if (fabs(b) < 0.1 * fabs(a) && fabs(c) < 0.1 * fabs(d))
        return straight[a < 0][d < 0];
    if (fabs(a) < 0.1 * fabs(b) && fabs(d) < 0.1 * fabs(c))
        return across[b < 0][c < 0];
    return 1;
}

/* ---- MP4, QuickTime: boxes ------------------------------------------------------------------------------- */

#define BOX(a, b, c, d) ((uint32_t)(a) << 24 | (uint32_t)(b) << 16 | (uint32_t)(c) << 8 | (uint32_t)(d))

static bool read_box(const source *s, part *p)
{
    const int64_t start = p->at;
    uint8_t head[16];
    uint64_t size;
    int64_t n = 8;

    if (!read_bytes(s, start, head, 8))
        return false;
    size = big_endian(head, 4);
    if (size == 1) {
        if (!read_bytes(s, start + 8, head + 8, 8))
            return false;
        size = big_endian(head + 8, 8);
        n = 16;
    } else if (size == 0) {                     /* the last one may leave it open */
        size = (uint64_t)(s->size - start);
    }
    if (size < (uint64_t)n || size > INT64_MAX / 2)
        return false;
    *p = (part){ (uint32_t)big_endian(head + 4, 4), start + n, start + (int64_t)size };
    return true;
}

/* The upper left of the matrix in a header whose version 1 has longer times; the unit's scale does not matter. */
static bool read_matrix(const source *s, const part *p, int at, int at_version1, double m[4])
{
    static const int place[4] = { 0, 1, 3, 4 };
    uint8_t version, b[36];

    if (!read_bytes(s, p->at, &version, 1))
        return false;
    at = version == 1 ? at_version1 : at;
    if (p->at + at + (int)sizeof(b) > p->end || !read_bytes(s, p->at + at, b, sizeof(b)))
        return false;
    for (int i = 0; i < 4; i++)
        m[i] = (double)(int32_t)big_endian(b + 4 * place[i], 4) / 65536;
    return true;
}

static bool shows_pictures(const source *s, const part *track)
{
    part media, handler;
    uint8_t kind[12];

    return find_part(s, read_box, track, BOX('m', 'd', 'i', 'a'), &media) &&
           find_part(s, read_box, &media, BOX('h', 'd', 'l', 'r'), &handler) &&
           read_bytes(s, handler.at, kind, sizeof(kind)) && memcmp(kind + 8, "vide", 4) == 0;
}

/* The track's matrix, then the film's. */
static int turned_in_track(const source *s, const part *movie, const part *track)
{
    double t[4] = { 1, 0, 0, 1 }, f[4] = { 1, 0, 0, 1 };
    part head;

    if (find_part(s, read_box, track, BOX('t', 'k', 'h', 'd'), &head))
        read_matrix(s, &head, 40, 52, t);
    if (find_part(s, read_box, movie, BOX('m', 'v', 'h', 'd'), &head))
        read_matrix(s, &head, 36, 48, f);
    return orientation_of(t[0] * f[0] + t[1] * f[2], t[0] * f[1] + t[1] * f[3], t[2] * f[0] + t[3] * f[2],
                          t[2] * f[1] + t[3] * f[3]);
}

static int turned_in_movie(const source *s, const part *movie)
{
    part p = { 0 };

    for (int i = 0; i < MOST_PARTS && next_part(s, read_box, movie, &p); i++)
        if (p.id == BOX('t', 'r', 'a', 'k') && shows_pictures(s, &p))
            return turned_in_track(s, movie, &p);
    return 1;
}

static void read_mp4(const source *s, lt_film_head *out)
{
    const part all = { 0, 0, INT64_MAX };
    part p = { 0 };

    for (int i = 0; i < MOST_PARTS && next_part(s, read_box, &all, &p); i++) {
        if (p.id == BOX('m', 'o', 'o', 'v'))
            out->orientation = turned_in_movie(s, &p);
        if (p.end > s->size)
            out->want_bytes = p.end;
    }
}

/* ---- Matroska, WebM: elements ---------------------------------------------------------------------------- */

enum {
    SEGMENT = 0x18538067, TRACKS = 0x1654AE6B, CLUSTER = 0x1F43B675, TRACK = 0xAE, TRACK_TYPE = 0x83, VIDEO = 0xE0,
    PROJECTION = 0x7670, POSE_YAW = 0x7673, POSE_PITCH = 0x7674, POSE_ROLL = 0x7675, PICTURES = 1,
};

/* A number whose first byte's leading zeros say how many bytes follow; 0 bytes where it is none. */
static int read_vint(const source *s, int64_t at, int most, uint64_t *out)
{
    uint8_t b[8];
    int n = 1;

    if (!read_bytes(s, at, b, 1) || b[0] == 0)
        return 0;
    while (!(b[0] & 0x80 >> (n - 1)))
        n++;
    if (n > most || !read_bytes(s, at, b, (size_t)n))
        return 0;
    *out = big_endian(b, (size_t)n);
    return n;
}

static bool read_element(const source *s, part *p)
{
    uint64_t id, size;
    const int n_id = read_vint(s, p->at, 4, &id), n = n_id ? read_vint(s, p->at + n_id, 8, &size) : 0;

    if (!n)
        return false;
    size &= ((uint64_t)1 << 7 * n) - 1;
    p->id = (uint32_t)id;
    p->at += n_id + n;
    p->end = size == ((uint64_t)1 << 7 * n) - 1 ? s->size : p->at + (int64_t)size;     /* all ones: to the end */
    return true;
}

static double read_float(const source *s, const part *in, uint32_t id)
{
    uint8_t b[8];
    uint32_t single;
    uint64_t whole;
    double x = 0;
    float f;
    part p;

    if (!find_part(s, read_element, in, id, &p) || !read_bytes(s, p.at, b, (size_t)lt_min_i64(p.end - p.at, 8)))
        return 0;
    if (p.end - p.at == 4) {
        single = (uint32_t)big_endian(b, 4);
        memcpy(&f, &single, sizeof(f));
        x = (double)f;
    } else if (p.end - p.at == 8) {
        whole = big_endian(b, 8);
        memcpy(&x, &whole, sizeof(x));
    }
    return x;
}

/* Yaw first, of which half a turn is a mirror; then roll, against the clock. Other poses are of spheres. */
static int turned_in_video(const source *s, const part *video)
{
    double yaw, roll, c, r;
    part p;

    if (!find_part(s, read_element, video, PROJECTION, &p))
        return 1;
    yaw = fabs(read_float(s, &p, POSE_YAW));
    roll = read_float(s, &p, POSE_ROLL) * M_PI / 180;
    if (read_float(s, &p, POSE_PITCH) != 0 || (yaw != 0 && yaw != 180) || !isfinite(roll))
        return 1;
    c = cos(roll);
    r = sin(roll);
    return yaw == 0 ? orientation_of(c, -r, r, c) : orientation_of(-c, r, r, c);
}

static bool is_video_track(const source *s, const part *track)
{
    uint8_t kind;
    part p;

    return find_part(s, read_element, track, TRACK_TYPE, &p) && p.end - p.at == 1 && read_bytes(s, p.at, &kind, 1) &&
           kind == PICTURES;
}

static int turned_in_tracks(const source *s, const part *tracks)
{
    part p = { 0 }, video;

    for (int i = 0; i < MOST_PARTS && next_part(s, read_element, tracks, &p); i++)
        if (p.id == TRACK && is_video_track(s, &p))
            return find_part(s, read_element, &p, VIDEO, &video) ? turned_in_video(s, &video) : 1;
    return 1;
}

static void read_matroska(const source *s, lt_film_head *out)
{
    const part all = { 0, 0, INT64_MAX };
    part segment, p = { 0 };

    if (!find_part(s, read_element, &all, SEGMENT, &segment))
        return;
    if (segment.end > s->size)
        out->want_bytes = segment.end;
    for (int i = 0; i < MOST_PARTS && next_part(s, read_element, &segment, &p) && p.id != CLUSTER; i++)
        if (p.id == TRACKS) {
            out->orientation = turned_in_tracks(s, &p);
            return;
        }
}

lt_film_head lt_film_head_read(const char *path)
{
    lt_film_head head = { .orientation = 1 };
    struct stat info;
    source s;

    if (stat(path, &info) || !S_ISREG(info.st_mode))
        return head;
    s = (source){ fopen(path, "rb"), info.st_size };
    if (!s.f)
        return head;
    switch (lt_kind_of_file(path)) {
    case LT_KIND_MP4:      read_mp4(&s, &head); break;
    case LT_KIND_MATROSKA: read_matroska(&s, &head); break;
    default:               break;
    }
    fclose(s.f);
    return head;
}
