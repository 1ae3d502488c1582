/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures one behind the other through standard input: where each ends, and what is none. */
#include "pipeline/pipe.h"

#include "libtensor/io/file.h"
#include "libtensor/io/image/image.h"
#include "tests/io/io_vectors.h"
#include "tests/suite.h"

#include <unistd.h>

enum { SIDE = 9 };

static lt_arena *arena;
static uint8_t stream[1 << 16];
static size_t length;

static void put(const void *bytes, size_t n)
{
    ck_assert_uint_le(length + n, sizeof(stream));
    memcpy(stream + length, bytes, n);
    length += n;
}

/* A picture whose first pixel is (tone, 0, 0). */
static lt_image picture(int tone)
{
    lt_image img;

    check_ok(lt_image_init(arena, SIDE, SIDE, 3, 8, &img));
    memset(img.data, tone, lt_image_bytes(&img));
    return img;
}

static void put_ppm(int tone, const char *head)
{
    const lt_image img = picture(tone);

    put(head, strlen(head));
    put(img.data, lt_image_bytes(&img));
}

static void put_png(int tone)
{
    const lt_image img = picture(tone);
    uint8_t *bytes;
    size_t n;

    check_ok(lt_png_write(in_folder("a.png"), &img));
    check_ok(lt_read_file(arena, in_folder("a.png"), sizeof(stream), &bytes, &n));
    put(bytes, n);
}

static void put_jpeg(int tone)
{
    const lt_image img = picture(tone);
    uint8_t *bytes;
    size_t n;

    check_ok(lt_jpeg_encode(arena, &img, 95, &bytes, &n));
    put(bytes, n);
}

/* What was put so far, in place of standard input */
static pipe_reader *open_stream(void)
{
    pipe_reader *p;

    put_file(in_folder("stream"), stream, length);
    ck_assert_ptr_nonnull(freopen(in_folder("stream"), "rb", stdin));
    check_ok(pipe_open(NULL, &p));
    return p;
}

static void expect(pipe_reader *p, int width, int tone)
{
    lt_image img;
    bool more;

    check_ok(pipe_next(p, arena, &img, &more));
    ck_assert(more);
    ck_assert_int_eq(img.width, width);
    ck_assert_int_eq(img.channels, 3);
    if (tone >= 0)
        ck_assert_int_le(abs(img.data[0] - tone), 2);
}

static void expect_end(pipe_reader *p)
{
    lt_image img;
    bool more;

    check_ok(pipe_next(p, arena, &img, &more));
    ck_assert(!more);
    pipe_close(p);
}

START_TEST(each_format)
{
    pipe_reader *p;

    put_ppm(10, "P6\n9 9\n255\n");
    put_png(20);
    put_jpeg(30);
    put(jpeg_progressive, sizeof(jpeg_progressive));
    put_ppm(40, "P6 # of a camera\n# by hand\n 9\t9 255 ");
    put_png(50);
    p = open_stream();
    expect(p, SIDE, 10);
    expect(p, SIDE, 20);
    expect(p, SIDE, 30);
    expect(p, 32, -1);
    expect(p, SIDE, 40);
    expect(p, SIDE, 50);
    expect_end(p);
}
END_TEST

/* A picture whose end is known does no harm to the next. */
START_TEST(one_is_damaged)
{
    pipe_reader *p;
    lt_image img;
    bool more;

    put_png(20);
    stream[length - 20] ^= 0x55;
    put_jpeg(30);
    length -= 4;                                            /* breaks off where the next begins */
    put_jpeg(60);
    p = open_stream();
    ck_assert_int_eq(pipe_next(p, arena, &img, &more), LT_EFORMAT);
    ck_assert(more);
    if (pipe_next(p, arena, &img, &more) == LT_OK)          /* libjpeg may show what there is */
        ck_assert_int_eq(img.width, SIDE);
    ck_assert(more);
    expect(p, SIDE, 60);
    expect_end(p);
}
END_TEST

static void expect_last(lt_status status, const char *reason)
{
    pipe_reader *p = open_stream();
    lt_image img;
    bool more;

    check_error(pipe_next(p, arena, &img, &more), status, reason);
    ck_assert(!more);
    pipe_close(p);
}

/* Cut at every byte: an error each time, but for nothing at all. */
START_TEST(cut)
{
    static void (*const add[])(int) = { put_png, put_jpeg };

    add[_i](20);
    for (size_t n = length - 1; n > 0; n--) {
        length = n;
        expect_last(LT_EFORMAT, n < 8 && _i == 0 ? "no picture begins with" : n < 2 ? "no picture" : "ends within");
    }
}
END_TEST

START_TEST(wrong)
{
    static const struct { const char *bytes, *reason; } bad[] = {
        { "RIFF\x10\1\1\1", "no picture begins with 0x52 0x49; want PPM (P6), PNG or JPEG" },
        { "P6 9 9 65535 ", "a PPM of 9 x 9 pixels up to 65535, want 1 to 16384 and 255" },
        { "P6 0 9 255 ", "a PPM of 0 x 9" }, { "P6 99999999999 9 255 ", "a PPM" }, { "P6 9x9 255 ", "no head" },
        { "P6 9 9 255 xyz", "ends within a picture, of which 14 bytes are there" },
        { "\xff\xd8\x41", "ends within" }, { "\xff\xd8\x41\x42", "0x41 at byte 2, want a mark" },
    };

    length = strlen(bad[_i].bytes);
    memcpy(stream, bad[_i].bytes, length);
    expect_last(LT_EFORMAT, bad[_i].reason);
}
END_TEST

static void setup(void)
{
    arena = lt_arena_new();
    make_scratch_folder();
    length = 0;
}

static void teardown(void)
{
    remove_scratch_folder();
    lt_arena_free(arena);
}

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, setup, teardown);
    tcase_add_test(t, each_format);
    tcase_add_test(t, one_is_damaged);
    tcase_add_loop_test(t, cut, 0, 2);
    tcase_add_loop_test(t, wrong, 0, 8);
}

int main(void)
{
    return run_suite("pipe", add_tests);
}
