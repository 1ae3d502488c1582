/* SPDX-License-Identifier: Apache-2.0 */
/* Images: Pillow's files, round trips, damage, and sizes that cannot be. */
#define _GNU_SOURCE                     /* dladdr */
#include <config.h>
#include "libtensor/io/image/film.h"
#include "libtensor/io/image/image.h"
#include "tests/io/hostile.h"
#include "tests/io/io_vectors.h"

#include <dlfcn.h>
#include <sys/resource.h>
#include <unistd.h>
#include <zlib.h>

#include <jpeglib.h>

static lt_status read_image(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    lt_image img;

    return lt_image_decode(arena, "x.img", bytes, n, &img);
}

/* What Pillow was given: gray = 7 i, 7 wide and 5 high. */
static const struct {
    const uint8_t *bytes;
    size_t n;
    int channels, bits;
} pngs[] = {
    { png_gray, sizeof(png_gray), 1, 8 }, { png_deep, sizeof(png_deep), 1, 16 },
    { png_bits, sizeof(png_bits), 1, 8 }, { png_rgb, sizeof(png_rgb), 3, 8 },
    { png_palette, sizeof(png_palette), 3, 8 }, { png_gray_alpha, sizeof(png_gray_alpha), 4, 8 },
};

START_TEST(foreign_png)
{
    lt_arena *arena = lt_arena_new();
    lt_image img;

    check_ok(lt_image_decode(arena, "p", pngs[_i].bytes, pngs[_i].n, &img));
    ck_assert(img.width == 7 && img.height == 5);
    ck_assert(img.channels == pngs[_i].channels && img.bits == pngs[_i].bits);
    for (int i = 0; i < 35; i++) {
        if (pngs[_i].bytes == png_gray)
            ck_assert_int_eq(img.data[i], 7 * i);
        if (pngs[_i].bytes == png_bits)
            ck_assert_int_eq(img.data[i], 7 * i > 100 ? 255 : 0);
        if (pngs[_i].bytes == png_deep)
            ck_assert_int_eq(((uint16_t *)(void *)img.data)[i], 7 * i * 257 + 1);
        if (pngs[_i].bytes == png_rgb)
            ck_assert(img.data[3 * i] == 7 * i && img.data[3 * i + 1] == 255 - 7 * i);
        if (pngs[_i].bytes == png_gray_alpha)
            ck_assert(img.data[4 * i + 2] == 7 * i && img.data[4 * i + 3] == 7 * i);
    }
    check_truncated(read_image, pngs[_i].bytes, pngs[_i].n, 0);
    check_flipped(read_image, pngs[_i].bytes, pngs[_i].n, 1000);
    lt_arena_free(arena);
}
END_TEST

START_TEST(foreign_jpeg)
{
    lt_arena *arena = lt_arena_new();
    lt_image img;

    check_ok(lt_image_decode(arena, "p", jpeg_progressive, sizeof(jpeg_progressive), &img));
    ck_assert(img.width == 32 && img.height == 24 && img.channels == 3 && img.bits == 8);
    for (size_t i = 0; i < sizeof(jpeg_progressive_rgb); i++)
        ck_assert_int_le(abs(img.data[i] - jpeg_progressive_rgb[i]), 1);
    check_ok(lt_image_decode(arena, "g", jpeg_gray, sizeof(jpeg_gray), &img));
    ck_assert_int_eq(img.channels, 1);
    check_truncated(read_image, jpeg_progressive, sizeof(jpeg_progressive), 0);
    check_truncated(read_image, jpeg_gray, sizeof(jpeg_gray), 2);       /* the marker of its end */
    check_ok(attempt(read_image, jpeg_gray, sizeof(jpeg_gray) - 2));
    check_flipped(read_image, jpeg_progressive, sizeof(jpeg_progressive), 3000);
    check_flipped(read_image, jpeg_gray, sizeof(jpeg_gray), 3000);
    lt_arena_free(arena);
}
END_TEST

/* Pillow's CMYK of the picture of png_rgb, which has no black: what it was made of comes back. */
START_TEST(cmyk_jpeg)
{
    lt_arena *arena = lt_arena_new();
    lt_image img;

    check_ok(lt_image_decode(arena, "c", jpeg_cmyk, sizeof(jpeg_cmyk), &img));
    ck_assert(img.width == 7 && img.height == 5 && img.channels == 3 && img.bits == 8);
    for (size_t i = 0; i < sizeof(jpeg_cmyk_rgb); i++)
        ck_assert_int_le(abs(img.data[i] - jpeg_cmyk_rgb[i]), 1);
    check_truncated(read_image, jpeg_cmyk, sizeof(jpeg_cmyk), 2);
    check_flipped(read_image, jpeg_cmyk, sizeof(jpeg_cmyk), 3000);
    lt_arena_free(arena);
}
END_TEST

/* 16 x 16 pixels of these inks, 255 for none, as libjpeg writes them. */
static size_t write_inks(const uint8_t inks[4], J_COLOR_SPACE as, uint8_t **jpeg)
{
    struct jpeg_error_mgr errors;
    struct jpeg_compress_struct c = { .err = jpeg_std_error(&errors) };
    uint8_t row[16 * 4];
    JSAMPROW rows = row;
    unsigned long n = 0;

    for (int i = 0; i < 16 * 4; i++)
        row[i] = inks[i % 4];
    jpeg_create_compress(&c);
    jpeg_mem_dest(&c, jpeg, &n);
    c.image_width = c.image_height = 16;
    c.input_components = 4;
    c.in_color_space = JCS_CMYK;
    jpeg_set_defaults(&c);
    jpeg_set_colorspace(&c, as);
    jpeg_set_quality(&c, 100, TRUE);
    jpeg_start_compress(&c, TRUE);
    while (c.next_scanline < 16)
        jpeg_write_scanlines(&c, &rows, 1);
    jpeg_finish_compress(&c);
    jpeg_destroy_compress(&c);
    return n;
}

/* Photoshop stores inks inverted, in either way */
START_TEST(mixed_inks)
{
    static const uint8_t inks[][4] = { { 255, 0, 0, 255 }, { 200, 100, 50, 128 }, { 255, 255, 255, 0 },
                                       { 9, 9, 9, 255 } };
    static const uint8_t rgb[][3] = { { 255, 0, 0 }, { 100, 50, 25 }, { 0, 0, 0 }, { 9, 9, 9 } };
    static const J_COLOR_SPACE as[] = { JCS_CMYK, JCS_YCCK };
    lt_arena *arena = lt_arena_new();
    lt_image img;

    for (size_t i = 0; i < LT_COUNT(inks); i++)
        for (size_t k = 0; k < LT_COUNT(as); k++) {
            uint8_t *jpeg = NULL;
            const size_t n = write_inks(inks[i], as[k], &jpeg);

            check_ok(lt_image_decode(arena, "i", jpeg, n, &img));
            for (int c = 0; c < 3; c++)
                ck_assert_int_le(abs(img.data[3 * 100 + c] - rgb[i][c]), 2);
            free(jpeg);
        }
    lt_arena_free(arena);
}
END_TEST

START_TEST(other_formats)
{
    lt_arena *arena = lt_arena_new();

    setenv("PALMAR_MODULES", MODULES, 1);
    check_refused(read_image, "", 0, "empty file");
    check_refused(read_image, "hello, this is text", 19, "x.img: ");
#ifdef HAVE_OPENCV
    lt_image img;

    check_ok(lt_image_decode(arena, "b", bmp_rgb, sizeof(bmp_rgb), &img));
    ck_assert(img.width == 7 && img.height == 5 && img.channels == 3);
    ck_assert(img.data[3] == 7 && img.data[4] == 248);
#endif
    lt_arena_free(arena);
}
END_TEST

/* Netpbm's formats, by hand: gray, with alpha, of 16 bits, and of kinds that are not read */
START_TEST(kinds_of_samples)
{
#ifdef HAVE_OPENCV
    static const struct {
        const char *bytes;
        size_t n;
        int channels, bits;
        unsigned second;                /* sample */
    } cases[] = {
        { "P5 2 1 255\n\x07\x09", 13, 1, 8, 9 }, { "P6 1 1 255\n\x07\x08\x09", 14, 3, 8, 8 },
        { "P5 2 1 65535\n\0\x07\1\0", 17, 1, 16, 256 },
        { "P7\nWIDTH 1\nHEIGHT 1\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\n\x07\x08\x09\x0a", 69, 4, 8, 8 },
    };
    lt_arena *arena = lt_arena_new(), *none = lt_arena_new();
    lt_image img;

    setenv("PALMAR_MODULES", MODULES, 1);
    for (size_t i = 0; i < LT_COUNT(cases); i++) {
        check_ok(lt_image_decode(arena, "n", (const uint8_t *)cases[i].bytes, cases[i].n, &img));
        ck_assert_msg(img.channels == cases[i].channels && img.bits == cases[i].bits, "%zu: %d channels of %d bits", i,
                      img.channels, img.bits);
        ck_assert_uint_eq(img.bits == 8 ? img.data[1] : ((uint16_t *)(void *)img.data)[1], cases[i].second);
    }
    check_refused(read_image, "Pf\n1 1\n-1.0\n\0\0\x80\x3f", 16, "x.img: samples of a kind that is not read");
    lt_alloc_fail_at(1);
    check_error(lt_image_decode(none, "n", bmp_rgb, sizeof(bmp_rgb), &img), LT_ENOMEM, "no memory");
    lt_alloc_fail_at(0);
    lt_arena_free(none);
    lt_arena_free(arena);
#endif
}
END_TEST

/* A folder in which the module is missing, is none, or is another library */
static const char *without_module(int kind)
{
    const char *name = in_folder("images-opencv.so");
    Dl_info other;

    unlink(name);
    if (kind == 1)
        put_file(name, "no library", 10);
    if (kind == 2) {
        ck_assert_int_ne(dladdr((void *)(uintptr_t)&dlopen, &other), 0);
        ck_assert_int_eq(symlink(other.dli_fname, name), 0);
    }
    return scratch_folder;
}

START_TEST(without_the_module)
{
    static const char lfs[] = "version https://git-lfs.github.com/spec/v1\n";
    lt_arena *arena = lt_arena_new();
    lt_film *film;

    setenv("PALMAR_MODULES", without_module(_i), 1);
    check_refused(read_image, lfs, strlen(lfs), "x.img: a git-lfs pointer");
    check_refused(read_image, bmp_rgb, sizeof(bmp_rgb), "x.img: neither PNG nor JPEG; other formats need a build with");
    put_file(in_folder("f.avi"), "RIFF", 4);
    check_error(lt_film_open(in_folder("f.avi"), &film), LT_EFORMAT, "f.avi: films need a build with OpenCV");
    check_ok(lt_image_decode(arena, "p", png_gray, sizeof(png_gray), &(lt_image){ 0 }));
    lt_arena_free(arena);
}
END_TEST

/* The header asks for 16384 x 6000 pixels; the file has a few dozen bytes. */
START_TEST(huge_claims)
{
    uint8_t bytes[sizeof(jpeg_gray)];

    memcpy(bytes, png_gray, sizeof(png_gray));
    memcpy(bytes + 16, "\0\0\x40\0\0\0\x17\x70", 8);
    memcpy(bytes + 29, "\x18\xc2\x2a\xb3", 4);          /* a wrong checksum is refused before the size */
    check_refused(read_image, bytes, sizeof(png_gray), "bad PNG");
    memcpy(bytes, jpeg_gray, sizeof(jpeg_gray));
    for (size_t i = 0; i + 8 < sizeof(bytes); i++)
        if (bytes[i] == 0xff && bytes[i + 1] == 0xc0)
            memcpy(bytes + i + 5, "\x17\x70\x40\0", 4);
    check_refused(read_image, bytes, sizeof(bytes), "16384 x 6000 pixels cannot be in");
    for (size_t i = 0; i + 8 < sizeof(bytes); i++)
        if (bytes[i] == 0xff && bytes[i + 1] == 0xc0)
            memcpy(bytes + i + 5, "\x7f\xff\x7f\xff", 4);
    check_refused(read_image, bytes, sizeof(bytes), "32767 x 32767 pixels, want");
}
END_TEST

/* A chunk of n bytes behind the n_png bytes of a PNG file. */
static size_t put_chunk(uint8_t *png, size_t n_png, const char *type, const void *bytes, size_t n)
{
    uint8_t *p = png + n_png;
    uint32_t crc;

    memcpy(p + 4, type, 4);
    if (n)
        memcpy(p + 8, bytes, n);
    crc = (uint32_t)crc32(0, p + 4, (uInt)n + 4);
    for (int i = 0; i < 4; i++) {
        p[i] = (uint8_t)(n >> (24 - 8 * i));
        p[8 + n + (size_t)i] = (uint8_t)(crc >> (24 - 8 * i));
    }
    return n_png + n + 12;
}

static long peak_megabytes(void)
{
    struct rusage use;

    getrusage(RUSAGE_SELF, &use);
    return use.ru_maxrss >> 10;
}

/* Text that deflate packs a thousandfold, a hundred times over: nobody reads it, so it stays packed. */
START_TEST(packed_text)
{
    enum { TEXT = 4 << 20, TIMES = 100 };
    uLongf n_text = 1 << 16;
    uint8_t *png = malloc(sizeof(png_rgb) + TIMES * (n_text + 12)), *text = malloc(TEXT), packed[1 << 16] = "k";
    const size_t head = 8 + 25, n_tail = sizeof(png_rgb) - head;        /* magic and IHDR */
    const long before = peak_megabytes();
    lt_arena *arena = lt_arena_new();
    lt_image img;
    size_t n = head;

    memset(text, 'a', TEXT);
    n_text -= 3;
    ck_assert_int_eq(compress(packed + 3, &n_text, text, TEXT), Z_OK);
    memcpy(png, png_rgb, head);
    for (int i = 0; i < TIMES; i++)
        n = put_chunk(png, n, "zTXt", packed, n_text + 3);
    memcpy(png + n, png_rgb + head, n_tail);
    check_ok(lt_image_decode(arena, "t", png, n + n_tail, &img));
    ck_assert(img.data[3] == 7 && img.data[4] == 248);
    ck_assert_msg(peak_megabytes() - before < 100, "%ld MB, before %ld", peak_megabytes(), before);
    lt_arena_free(arena);
    free(text);
    free(png);
}
END_TEST

/* A progressive JPEG that says again and again, in a few bytes, that nothing is added to any pixel */
START_TEST(endless_scans)
{
    enum { SIDE = 3400, BLOCKS = SIDE / 8 * (SIDE / 8), SCANS = 60 };
    static const uint8_t head[] = {
        0xff, 0xd8, 0xff, 0xc2, 0, 11, 8, SIDE >> 8, SIDE & 255, SIDE >> 8, SIDE & 255, 1, 1, 0x11, 0,
        0xff, 0xc4, 0, 20, 0x00, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x00,      /* DC: 0 is "as before" */
        0xff, 0xc4, 0, 20, 0x10, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xe0,      /* AC: 0 is a long run */
        0xff, 0xda, 0, 8, 1, 1, 0x00, 0, 0, 0,
    };
    static const uint8_t scan[] = { 0xff, 0xda, 0, 8, 1, 1, 0x00, 1, 63, 0 };
    const size_t runs = (15 * ((BLOCKS + 16383) / 16384) + 7) / 8, dc = (BLOCKS + 7) / 8;
    uint8_t *jpeg = calloc(1, sizeof(head) + 69 + dc + SCANS * (sizeof(scan) + runs) + 2), *p = jpeg;

    memcpy(p, head, 2);
    memcpy(p + 2, "\xff\xdb\0\x43", 4);          /* all quantised by 1 */
    memset(p + 7, 1, 64);
    memcpy(p + 71, head + 2, sizeof(head) - 2);
    p += 69 + sizeof(head) + dc;
    for (int i = 0; i < SCANS; i++, p += sizeof(scan) + runs)
        memcpy(p, scan, sizeof(scan));
    memcpy(p, "\xff\xd9", 2);
    check_refused(read_image, jpeg, (size_t)(p - jpeg) + 2, "more than 24 scans of 11560000 pixels");
    free(jpeg);
}
END_TEST

START_TEST(png_round_trip)
{
    static const int channels[] = { 1, 3, 4 };
    lt_arena *arena = lt_arena_new();
    lt_rng rng = lt_rng_make(3, 0);
    lt_image img, back;

    check_ok(lt_image_init(arena, 37, 5, channels[_i % 3], _i < 3 ? 8 : 16, &img));
    for (size_t i = 0; i < lt_image_bytes(&img); i++)
        img.data[i] = (uint8_t)lt_rng_u32(&rng);
    for (int fast = 0; fast < 2; fast++) {
        check_ok((fast ? lt_png_write_fast : lt_png_write)(in_folder("r.png"), &img));
        check_ok(lt_image_read(arena, in_folder("r.png"), &back));
        ck_assert(back.width == 37 && back.height == 5);
        ck_assert(back.channels == img.channels && back.bits == img.bits);
        ck_assert_mem_eq(back.data, img.data, lt_image_bytes(&img));
    }
    check_ok(lt_image_to_rgb8(arena, &img, &back));
    ck_assert(back.channels == 3 && back.bits == 8);
    lt_arena_free(arena);
}
END_TEST

START_TEST(jpeg_round_trip)
{
    lt_arena *arena = lt_arena_new();
    lt_image img, back;
    uint8_t *bytes;
    size_t n;

    check_ok(lt_image_init(arena, 33, 17, _i ? 3 : 1, 8, &img));
    for (int y = 0; y < 17; y++)
        for (int x = 0; x < 33 * img.channels; x++)
            img.data[y * 33 * img.channels + x] = (uint8_t)(x / img.channels * 5 + y * 2);
    check_ok(lt_jpeg_write(in_folder("r.jpg"), &img, 95));
    check_ok(lt_image_read(arena, in_folder("r.jpg"), &back));
    ck_assert(back.width == 33 && back.height == 17 && back.channels == img.channels);
    for (size_t i = 0; i < lt_image_bytes(&img); i++)
        ck_assert_int_le(abs(img.data[i] - back.data[i]), 4);
    check_ok(lt_jpeg_encode(arena, &img, 95, &bytes, &n));
    check_truncated(read_image, bytes, n, 2);
    check_ok(attempt(read_image, bytes, n - 2));
    check_error(lt_jpeg_encode(arena, &img, 0, &bytes, &n), LT_EINVAL, "quality 0");
    check_ok(lt_image_init(arena, 3, 3, 4, 8, &img));
    check_error(lt_jpeg_encode(arena, &img, 95, &bytes, &n), LT_EINVAL, "4 channels");
    lt_arena_free(arena);
}
END_TEST

START_TEST(cannot_be_made)
{
    lt_arena *arena = lt_arena_new();
    lt_image img;

    check_error(lt_image_init(arena, 0, 5, 3, 8, &img), LT_EINVAL, "0 x 5");
    check_error(lt_image_init(arena, 16384, 16384, 3, 8, &img), LT_EINVAL, "16384 x 16384");
    check_error(lt_image_init(arena, 5, 5, 2, 8, &img), LT_EINVAL, "2 channels");
    check_error(lt_image_read(arena, in_folder("no.png"), &img), LT_EIO, "no.png: No such file");
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_loop_test(tc, foreign_png, 0, LT_COUNT(pngs));
    tcase_add_test(tc, foreign_jpeg);
    tcase_add_test(tc, cmyk_jpeg);
    tcase_add_test(tc, mixed_inks);
    tcase_add_test(tc, other_formats);
    tcase_add_test(tc, kinds_of_samples);
    tcase_add_loop_test(tc, without_the_module, 0, 3);
    tcase_add_test(tc, huge_claims);
    tcase_add_test(tc, packed_text);
    tcase_add_test(tc, endless_scans);
    tcase_add_loop_test(tc, png_round_trip, 0, 6);
    tcase_add_loop_test(tc, jpeg_round_trip, 0, 2);
    tcase_add_test(tc, cannot_be_made);
}

int main(void)
{
    return run_suite("image", add_tests);
}
