/* SPDX-License-Identifier: Apache-2.0 */
/* EXIF: a TIFF directory in a segment or chunk of an image file. Every offset is checked against it. */
#include "libtensor/io/image/exif.h"

#include "libtensor/io/kind.h"

#include <math.h>
#include <string.h>

enum {
    TAG_ORIENTATION = 0x0112, TAG_EXIF = 0x8769, TAG_FOCAL = 0x920A, TAG_WIDTH = 0xA002, TAG_HEIGHT = 0xA003,
    TAG_PLANE_RESOLUTION = 0xA20E, TAG_PLANE_UNIT = 0xA210, TAG_FOCAL_35MM = 0xA405,
    TYPE_SHORT = 3, TYPE_LONG = 4, TYPE_RATIONAL = 5,
    ENTRY = 12, MAX_ENTRIES = 512, MAX_FOCAL_MM = 5000, MAX_SIDE_PX = 1 << 20, INCH = 2,
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

/* The value of an entry that is one fraction from above 0 to most; 0 when it is anything else. */
static double fraction(const tiff *t, size_t entry, double most)
{
    const size_t at = number(t, entry + 8, 4);
    double x;

    if (number(t, entry + 2, 2) != TYPE_RATIONAL || number(t, entry + 4, 4) != 1 || t->n < 8 || at > t->n - 8)
        return 0;
    x = (double)number(t, at, 4) / number(t, at + 4, 4);
    return x > 0 && x <= most ? x : 0;          /* neither x / 0 nor 0 / 0 is */
}

/* What both directories say, before it is put together. */
typedef struct {
    lt_exif exif;
    double resolution;          /* pixels a unit of the sensor */
    uint32_t unit, width, height;
} entries;

static void read_entry(const tiff *t, size_t entry, entries *e, size_t *deeper)
{
    const uint32_t v = value(t, entry);

    switch (number(t, entry, 2)) {
    case TAG_ORIENTATION:
        if (v >= 1 && v <= 8)
            e->exif.orientation = (int)v;
        break;
    case TAG_FOCAL_35MM:
        if (v >= 1 && v <= MAX_FOCAL_MM)
            e->exif.focal_35mm = v;
        break;
    case TAG_FOCAL: e->exif.focal_mm = fraction(t, entry, MAX_FOCAL_MM); break;
    case TAG_PLANE_RESOLUTION: e->resolution = fraction(t, entry, UINT32_MAX); break;
    case TAG_PLANE_UNIT: e->unit = v; break;
    case TAG_WIDTH: e->width = v; break;
    case TAG_HEIGHT: e->height = v; break;
    case TAG_EXIF: *deeper = v; break;
    default: break;
    }
}

/* Reads the directory at `at`; returns where the EXIF directory is, or 0. */
static size_t read_directory(const tiff *t, size_t at, entries *e)
{
    size_t deeper = 0, count;

    if (at < 8 || at > t->n || t->n - at < 2)
        return 0;
    count = number(t, at, 2);
    for (size_t i = 0; i < count && i < MAX_ENTRIES; i++) {
        const size_t entry = at + 2 + ENTRY * i;

        if (t->n < ENTRY || entry > t->n - ENTRY)
            break;
        read_entry(t, entry, e, &deeper);
    }
    return deeper;
}

/* Units are Exif's inch and cm, and the mm and um that some cameras write; 1 is "none". */
static double units_per_mm(uint32_t unit)
{
    static const double per_mm[] = { [1] = 0, [INCH] = 1 / 25.4, [3] = 0.1, [4] = 1, [5] = 1000 };

    return unit < LT_COUNT(per_mm) ? per_mm[unit] : 0;
}

static lt_exif read_tiff(const uint8_t *p, size_t n)
{
    entries e = { .exif.orientation = 1, .unit = INCH };
    tiff t = { p, n, n > 0 && p[0] == 'M' };
    uint32_t longer;
    size_t deeper;

    if (n < 8 || (memcmp(p, "II*\0", 4) && memcmp(p, "MM\0*", 4)))
        return e.exif;
    deeper = read_directory(&t, number(&t, 4, 4), &e);
    if (deeper)
        read_directory(&t, deeper, &e);
    longer = e.width > e.height ? e.width : e.height;
    e.exif.longer_px = longer <= MAX_SIDE_PX ? longer : 0;
    e.exif.sensor_px_per_mm = e.resolution * units_per_mm(e.unit);
    return e.exif;
}

/* ---- where it stands ------------------------------------------------------------------------------------- */

static uint32_t big_endian(const uint8_t *b)
{
    return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3];
}

static uint32_t little_endian(const uint8_t *b)
{
    return (uint32_t)b[3] << 24 | (uint32_t)b[2] << 16 | (uint32_t)b[1] << 8 | b[0];
}

/* A segment's or chunk's bytes, before which some writers put the JPEG's mark wherever it stands. */
static lt_exif read_part(const uint8_t *p, size_t n)
{
    const size_t mark = n >= 6 && memcmp(p, "Exif\0", 5) == 0 ? 6 : 0;

    return read_tiff(p + mark, n - mark);
}

static lt_exif in_jpeg(const uint8_t *b, size_t n)
{
    size_t at = 2;

    while (n - at >= 4 && b[at] == 0xff && b[at + 1] != 0xda) {         /* until the scan begins */
        const size_t length = (size_t)b[at + 2] << 8 | b[at + 3];

        if (b[at + 1] == 0xff) {                                        /* a filler */
            at++;
            continue;
        }
        if (length < 2 || length > n - at - 2)
            break;
        if (b[at + 1] == 0xe1 && length >= 8 && memcmp(b + at + 4, "Exif\0", 5) == 0)
            return read_part(b + at + 4, length - 2);
        at += 2 + length;
    }
    return read_tiff(NULL, 0);
}

/* Before the pixels or behind them */
static lt_exif in_png(const uint8_t *b, size_t n)
{
    size_t at = 8;

    while (n - at >= 12) {
        const size_t length = big_endian(b + at);

        if (length > n - at - 12)
            break;
        if (memcmp(b + at + 4, "eXIf", 4) == 0)
            return read_part(b + at + 8, length);
        at += 12 + length;
    }
    return read_tiff(NULL, 0);
}

static lt_exif in_webp(const uint8_t *b, size_t n)
{
    size_t at = 12;

    while (n - at >= 8) {
        const size_t length = little_endian(b + at + 4);

        if (length > n - at - 8)
            break;
        if (memcmp(b + at, "EXIF", 4) == 0)
            return read_part(b + at + 8, length);
        at += 8 + length;
        at += at < n && length % 2;                                     /* chunks begin at even places */
    }
    return read_tiff(NULL, 0);
}

lt_exif lt_exif_read(const uint8_t *bytes, size_t n)
{
    switch (lt_kind_of(bytes, n)) {
    case LT_KIND_JPEG: return in_jpeg(bytes, n);
    case LT_KIND_PNG:  return in_png(bytes, n);
    case LT_KIND_WEBP: return in_webp(bytes, n);
    default:           return read_tiff(NULL, 0);
    }
}

/* ---- what it says of a picture --------------------------------------------------------------------------- */

/* A picture that was made smaller since has fewer pixels a millimetre. */
static double by_sensor(const lt_exif *exif, double longer)
{
    const double scale = exif->longer_px > 0 ? longer / exif->longer_px : 1;

    return exif->focal_mm * exif->sensor_px_per_mm * scale;
}

double lt_exif_focal_px(const lt_exif *exif, int width, int height)
{
    const double longer = width > height ? width : height;
    const double focal = exif->focal_35mm > 0 ? exif->focal_35mm * hypot(width, height) / hypot(36, 24)
                                              : by_sensor(exif, longer);

    return focal >= longer / 10 && focal <= 100 * longer ? focal : 0;
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

void lt_exif_upright(int orientation, int width, int height, size_t pixel_bytes, const void *stored, void *upright)
{
    const int columns = orientation < 5 ? width : height, rows = orientation < 5 ? height : width;
    const uint8_t *from = stored;
    uint8_t *to = upright;

    for (int y = 0; y < rows; y++)
        for (int x = 0; x < columns; x++) {
            int u, v;

            lt_exif_turn(orientation, width, height, x, y, &u, &v);
            memcpy(to, from + ((size_t)v * (size_t)width + (size_t)u) * pixel_bytes, pixel_bytes);
            to += pixel_bytes;
        }
}
