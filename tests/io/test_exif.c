/* SPDX-License-Identifier: Apache-2.0 */
/* What cameras write beside the picture, whole, cut, and bent. */
#include "libtensor/io/image/exif.h"
#include "tests/io/picture_vectors.h"
#include "tests/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LENGTH = 82, SEGMENT_END = 68 };

/* A JPEG's first bytes: one APP1 with orientation 6 and, in the EXIF directory, 28 mm. */
static const uint8_t little[LENGTH] = {
    0xff, 0xd8, 0xff, 0xe1, 0, 64, 'E', 'x', 'i', 'f', 0, 0,
    'I', 'I', 42, 0, 8, 0, 0, 0,
    2, 0,
    0x12, 0x01, 3, 0, 1, 0, 0, 0, 6, 0, 0, 0,
    0x69, 0x87, 4, 0, 1, 0, 0, 0, 38, 0, 0, 0,
    0, 0, 0, 0,
    1, 0,
    0x05, 0xa4, 3, 0, 1, 0, 0, 0, 28, 0, 0, 0,
    0, 0, 0, 0,
    0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0, 1, 2, 3, 4,
};

static const uint8_t big[] = {
    0xff, 0xd8, 0xff, 0xe0, 0, 4, 'J', 'F', 0xff, 0xe1, 0, 34, 'E', 'x', 'i', 'f', 0, 0,
    'M', 'M', 0, 42, 0, 0, 0, 8,
    0, 1,
    0xa4, 0x05, 0, 3, 0, 0, 0, 1, 0, 50, 0, 0,
    0, 0, 0, 0,
};

static bool sane(lt_exif e)
{
    const double focal = lt_exif_focal_px(&e, 640, 480);

    return e.orientation >= 1 && e.orientation <= 8 && e.focal_35mm >= 0 && e.focal_35mm <= 5000 && focal >= 0 &&
           focal <= 64000;
}

/* A copy of exactly n bytes, so that a read past the end is seen by the sanitizer. */
static lt_exif read_copy(const uint8_t *bytes, size_t n)
{
    uint8_t *copy = malloc(n ? n : 1);
    lt_exif e;

    memcpy(copy, bytes, n);
    e = lt_exif_read(copy, n);
    free(copy);
    return e;
}

START_TEST(values)
{
    lt_exif e = read_copy(little, LENGTH);

    ck_assert_int_eq(e.orientation, 6);
    ck_assert_double_eq(e.focal_35mm, 28);
    ck_assert_double_eq_tol(lt_exif_focal_px(&e, 3600, 2400), 2800, 1e-9);
    e = read_copy(big, sizeof(big));
    ck_assert_int_eq(e.orientation, 1);
    ck_assert_double_eq(e.focal_35mm, 50);
}
END_TEST

/* As Pillow writes it: before a PNG's pixels and behind them, behind a WebP's, and what two cameras say. */
START_TEST(other_files)
{
    const size_t chunk = 12 + 26, head = 8 + 25;        /* eXIf; the signature and IHDR, behind which it stands */
    uint8_t late[sizeof(exif_png)];
    lt_exif e = read_copy(exif_png, sizeof(exif_png));

    ck_assert_int_eq(e.orientation, 6);
    ck_assert_mem_eq(exif_png + head + 4, "eXIf", 4);
    memcpy(late, exif_png, head);
    memcpy(late + head, exif_png + head + chunk, sizeof(exif_png) - head - chunk - 12);
    memcpy(late + sizeof(late) - chunk - 12, exif_png + head, chunk);
    memcpy(late + sizeof(late) - 12, exif_png + sizeof(late) - 12, 12);
    ck_assert_int_eq(read_copy(late, sizeof(late)).orientation, 6);
    e = read_copy(exif_webp, sizeof(exif_webp));
    ck_assert_int_eq(e.orientation, 8);
    e = read_copy(exif_dslr, sizeof(exif_dslr));
    ck_assert_double_eq(e.focal_mm, 50);
    ck_assert_double_eq_tol(lt_exif_focal_px(&e, 5184, 3456), 50 * 5728.1767 / 25.4, 1e-6);
    ck_assert_double_eq_tol(lt_exif_focal_px(&e, 1728, 2592), 25 * 5728.1767 / 25.4, 1e-6);   /* half, and turned */
    ck_assert_double_eq_tol(lt_exif_focal_px(&e, 3000, 3456), 50 * 5728.1767 / 25.4 * 3456 / 5184, 1e-6);
    e = read_copy(exif_compact, sizeof(exif_compact));
    ck_assert_int_eq(e.orientation, 3);
    ck_assert_double_eq_tol(lt_exif_focal_px(&e, 1280, 960), 5.8 * 256, 1e-6);
    ck_assert_double_eq(lt_exif_focal_px(&e, 1280, 99999), 0);      /* no lens is so wide */
}
END_TEST

/* A segment behind fillers, and a chunk that begins with the JPEG's mark: both are met. */
START_TEST(other_writers)
{
    static const uint8_t webp[] = "RIFF\x2c\0\0\0WEBPEXIF\x20\0\0\0Exif\0\0MM\0\x2a\0\0\0\x08\0\1"
                                  "\1\x12\0\3\0\0\0\1\0\5\0\0\0\0\0";
    uint8_t jpeg[LENGTH + 2] = { 0xff, 0xd8, 0xff, 0xff };

    memcpy(jpeg + 4, little + 2, LENGTH - 2);
    ck_assert_int_eq(read_copy(jpeg, sizeof(jpeg)).orientation, 6);
    ck_assert_int_eq(read_copy(webp, sizeof(webp)).orientation, 5);
}
END_TEST

START_TEST(cut)
{
    for (size_t n = 0; n < LENGTH; n++) {
        const lt_exif e = read_copy(little, n);

        ck_assert(sane(e));
        if (n < SEGMENT_END)
            ck_assert_int_eq(e.orientation, 1);         /* a segment that is not all there is not read */
    }
}
END_TEST

/* Whatever stands in such a file */
static void bend(const uint8_t *bytes, size_t n)
{
    for (size_t i = 0; i < n; i++)
        for (int v = 0; v < 256; v += 5) {
            uint8_t b[1000];

            memcpy(b, bytes, n);
            b[i] = (uint8_t)v;
            ck_assert(sane(read_copy(b, n)));
        }
    for (size_t k = 0; k < n; k++)
        ck_assert(sane(read_copy(bytes, k)));
}

START_TEST(bent)
{
    bend(exif_png, sizeof(exif_png));
    bend(exif_webp, sizeof(exif_webp));
    bend(exif_dslr, sizeof(exif_dslr));
    for (size_t i = 0; i < LENGTH; i++)
        for (int v = 0; v < 256; v++) {
            uint8_t b[LENGTH];

            memcpy(b, little, LENGTH);
            b[i] = (uint8_t)v;
            ck_assert(sane(read_copy(b, LENGTH)));
        }
}
END_TEST

/* A directory that claims 65535 entries, and one that points to itself. */
START_TEST(hostile)
{
    uint8_t b[LENGTH];

    memcpy(b, little, LENGTH);
    b[20] = b[21] = 0xff;
    ck_assert(sane(read_copy(b, LENGTH)));
    memcpy(b, little, LENGTH);
    b[42] = 8;
    ck_assert_int_eq(read_copy(b, LENGTH).orientation, 6);
    memcpy(b, little, LENGTH);
    memset(b + 42, 0xff, 4);
    ck_assert_double_eq(read_copy(b, LENGTH).focal_35mm, 0);
}
END_TEST

/* A 3 x 2 picture, letters a to f row by row, upright under each orientation. */
START_TEST(turn)
{
    static const char *const upright[8] = {
        "abcdef", "cbafed", "fedcba", "defabc", "adbecf", "daebfc", "fcebda", "cfbead",
    };

    for (int o = 1; o <= 8; o++) {
        const int width = o < 5 ? 3 : 2;
        char all[6];

        for (int i = 0; i < 6; i++) {
            int x, y;

            lt_exif_turn(o, 3, 2, i % width, i / width, &x, &y);
            ck_assert_int_eq("abcdef"[3 * y + x], upright[o - 1][i]);
        }
        lt_exif_upright(o, 3, 2, 1, "abcdef", all);
        ck_assert_mem_eq(all, upright[o - 1], 6);
        lt_exif_upright(o, 3, 1, 2, "AaBbCc", all);             /* pixels of two bytes stay together */
        ck_assert(all[0] + 'a' - 'A' == all[1] && all[4] + 'a' - 'A' == all[5]);
    }
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_test(t, values);
    tcase_add_test(t, other_files);
    tcase_add_test(t, other_writers);
    tcase_add_test(t, cut);
    tcase_add_test(t, bent);
    tcase_add_test(t, hostile);
    tcase_add_test(t, turn);
}

int main(void)
{
    return run_suite("exif", add_tests);
}
