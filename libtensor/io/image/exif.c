/* SPDX-License-Identifier: Apache-2.0 */
/* EXIF: a TIFF directory inside a JPEG's APP1 segment. Every offset is checked against the segment. */
#include "libtensor/io/image/exif.h"

#include <math.h>
#include <string.h>

enum {
    TAG_ORIENTATION = 0x0112, TAG_EXIF = 0x8769, TAG_FOCAL_35MM = 0xA405,
    TYPE_SHORT = 3, TYPE_LONG = 4,
    ENTRY = 12, MAX_ENTRIES = 512, MAX_FOCAL_MM = 5000,
};

/* The TIFF part: offsets in it count from its first byte. */
typedef struct {
    const uint8_t *p;
    size_t n;
    bool big;                   /* Motorola byte order */
} tiff;

static uint32_t number(const tiff *t, size_t at, int bytes)
{
    uint32_t v = 0;

    for (int i = 0; i < bytes; i++)
        v = v << 8 | t->p[at + (size_t)(t->big ? i : bytes - 1 - i)];
    return v;
}

/* The value of an entry that is one whole number; 0 when it is anything else. */
static uint32_t value(const tiff *t, size_t entry)
{
    const uint32_t type = number(t, entry + 2, 2);

    if (number(t, entry + 4, 4) != 1 || (type != TYPE_SHORT && type != TYPE_LONG))
        return 0;
    return number(t, entry + 8, type == TYPE_SHORT ? 2 : 4);
}

/* Reads the directory at `at`; returns where the EXIF directory is, or 0. */
static size_t read_directory(const tiff *t, size_t at, lt_exif *out)
{
    size_t deeper = 0, count;

    if (at < 8 || at > t->n || t->n - at < 2)
        return 0;
    count = number(t, at, 2);
    for (size_t i = 0; i < count && i < MAX_ENTRIES; i++) {
        const size_t entry = at + 2 + ENTRY * i;

        if (t->n < ENTRY || entry > t->n - ENTRY)
            break;
        const uint32_t tag = number(t, entry, 2), v = value(t, entry);

        if (tag == TAG_ORIENTATION && v >= 1 && v <= 8)
            out->orientation = (int)v;
        else if (tag == TAG_FOCAL_35MM && v >= 1 && v <= MAX_FOCAL_MM)
            out->focal_35mm = v;
        else if (tag == TAG_EXIF)
            deeper = v;
    }
    return deeper;
}

static void read_tiff(const uint8_t *p, size_t n, lt_exif *out)
{
    tiff t = { p, n, n > 0 && p[0] == 'M' };
    size_t deeper;

    if (n < 8 || (memcmp(p, "II*\0", 4) && memcmp(p, "MM\0*", 4)))
        return;
    deeper = read_directory(&t, number(&t, 4, 4), out);
    if (deeper)
        read_directory(&t, deeper, out);
}

lt_exif lt_exif_read(const uint8_t *b, size_t n)
{
    lt_exif out = { .orientation = 1 };
    size_t at = 2;

    if (n < 2 || b[0] != 0xff || b[1] != 0xd8)
        return out;
    while (n - at >= 4 && b[at] == 0xff && b[at + 1] != 0xda) {         /* until the scan begins */
        const size_t length = (size_t)b[at + 2] << 8 | b[at + 3];

        if (length < 2 || length > n - at - 2)
            break;
        if (b[at + 1] == 0xe1 && length >= 8 && !memcmp(b + at + 4, "Exif\0", 6)) {
            read_tiff(b + at + 10, length - 8, &out);
            break;
        }
        at += 2 + length;
    }
    return out;
}

double lt_exif_focal_px(const lt_exif *exif, int width, int height)
{
    return exif->focal_35mm * hypot(width, height) / hypot(36, 24);
}

void lt_exif_turn(int orientation, int width, int height, int x, int y, int *from_x, int *from_y)
{
    const bool swap = orientation >= 5;
    const int u = swap ? y : x, v = swap ? x : y;
    const bool flip_x = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
    const bool flip_y = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;

    *from_x = flip_x ? width - 1 - u : u;
    *from_y = flip_y ? height - 1 - v : v;
}
