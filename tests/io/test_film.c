/* SPDX-License-Identifier: Apache-2.0 */
/* Films: frames, which way up they are, and files that are bent or cut. */
#define _GNU_SOURCE                     /* memmem */
#include <config.h>
#include "libtensor/io/image/film.h"
#include "libtensor/io/image/film_head.h"
#include "libtensor/io/image/image.h"
#include "tests/io/avi.h"
#include "tests/io/hostile.h"
#include "tests/io/picture_vectors.h"

#include <glob.h>

START_TEST(frames)
{
#ifdef HAVE_OPENCV
    static uint8_t pixels[16 * 8 * 3];
    lt_arena *arena = lt_arena_new(), *none = lt_arena_new();
    lt_image img;
    lt_film *f;
    bool more;

    setenv("PALMAR_MODULES", MODULES, 1);
    memset(pixels, 200, sizeof(pixels));
    avi_write(arena, in_folder("f.avi"),
              &(lt_image){ .width = 16, .height = 8, .channels = 3, .bits = 8, .data = pixels }, 25, 2);
    check_ok(lt_film_open(in_folder("f.avi"), &f));
    ck_assert_double_eq(lt_film_fps(f), 25);
    ck_assert_int_eq(lt_film_frames(f), 2);
    check_ok(lt_film_next(f, arena, &img, &more));
    ck_assert(more && img.width == 16 && img.height == 8 && img.channels == 3 && abs(img.data[0] - 200) < 3);
    lt_alloc_fail_at(1);
    check_error(lt_film_next(f, none, &img, &more), LT_ENOMEM, "no memory");
    lt_alloc_fail_at(0);
    check_ok(lt_film_next(f, arena, &img, &more));
    ck_assert(!more);
    lt_film_close(f);
    lt_film_close(NULL);
    lt_alloc_fail_at(1);
    check_error(lt_film_open(in_folder("f.avi"), &f), LT_ENOMEM, "f.avi: no memory");
    lt_alloc_fail_at(0);
    put_file(in_folder("g.avi"), "RIFF", 4);
    check_error(lt_film_open(in_folder("g.avi"), &f), LT_EFORMAT, "g.avi: not a film that can be read");
    check_error(lt_film_open(in_folder("none.avi"), &f), LT_EIO, "none.avi: No such file");
    lt_arena_free(none);
    lt_arena_free(arena);
#endif
}
END_TEST

/* The upper left of the matrix in the track's header: a, b, c, d. */
static const double matrices[8][4] = {
    { 1, 0, 0, 1 }, { -1, 0, 0, 1 }, { -1, 0, 0, -1 }, { 1, 0, 0, -1 },
    { 0, 1, 1, 0 }, { 0, 1, -1, 0 }, { 0, -1, -1, 0 }, { 0, -1, 1, 0 },
};

static uint8_t *find_box(uint8_t *bytes, size_t n, const char *name)
{
    uint8_t *box = memmem(bytes, n, name, 4);

    ck_assert_ptr_nonnull(box);
    return box + 4;
}

static void put_matrix(uint8_t *at, const double m[4], double scale)
{
    static const int place[4] = { 0, 1, 3, 4 };

    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            at[4 * place[i] + k] = (uint8_t)((uint32_t)(int32_t)(m[i] * scale * 65536) >> (24 - 8 * k));
}

/* FFmpeg's film with the track's and the film's own matrix changed. */
static const char *turned_film(const double track[4], const double movie[4], double scale)
{
    const char *path = in_folder("turned.mp4");
    uint8_t bytes[sizeof(film_turned)];

    memcpy(bytes, film_turned, sizeof(bytes));
    put_matrix(find_box(bytes, sizeof(bytes), "tkhd") + 40, track, scale);
    put_matrix(find_box(bytes, sizeof(bytes), "mvhd") + 36, movie, 1);
    put_file(path, bytes, sizeof(bytes));
    return path;
}

START_TEST(orientations)
{
    static const double oblique[4] = { 0.7, 0.7, -0.7, 0.7 }, nothing[4] = { 0 };

    for (int o = 0; o < 8; o++) {
        ck_assert_int_eq(lt_film_head_read(turned_film(matrices[o], matrices[0], 1)).orientation, o + 1);
        ck_assert_int_eq(lt_film_head_read(turned_film(matrices[o], matrices[0], 1.5)).orientation, o + 1);
        ck_assert_int_eq(lt_film_head_read(turned_film(matrices[0], matrices[o], 1)).orientation, o + 1);
    }
    ck_assert_int_eq(lt_film_head_read(turned_film(matrices[5], matrices[5], 1)).orientation, 3);
    ck_assert_int_eq(lt_film_head_read(turned_film(matrices[1], matrices[5], 1)).orientation, 7);
    ck_assert_int_eq(lt_film_head_read(turned_film(oblique, matrices[0], 1)).orientation, 1);
    ck_assert_int_eq(lt_film_head_read(turned_film(nothing, matrices[0], 1)).orientation, 1);
    put_file(in_folder("turned.mkv"), film_turned_mkv, sizeof(film_turned_mkv));
    ck_assert_int_eq(lt_film_head_read(in_folder("turned.mkv")).orientation, 8);
    ck_assert_int_eq(lt_film_head_read(in_folder("none.mkv")).orientation, 1);
    ck_assert_int_eq(lt_film_head_read(scratch_folder).orientation, 1);
}
END_TEST

static void check_corner(const lt_image *img, int x, int y, const uint8_t rgb[3])
{
    for (int c = 0; c < 3; c++)
        ck_assert_int_le(abs(img->data[3 * (y * img->width + x) + c] - rgb[c]), 12);
}

static void first_frame(lt_arena *arena, const char *path, int orientation, lt_image *img)
{
    lt_film *f;
    bool more;

    check_ok(lt_film_open(path, &f));
    ck_assert_int_eq(lt_film_orientation(f), orientation);
    check_ok(lt_film_next(f, arena, img, &more));
    ck_assert(more);
    lt_film_close(f);
}

/* Corners go round by one with each quarter turn; FFmpeg says how one film of the kinds is shown. */
START_TEST(upright)
{
#ifdef HAVE_OPENCV
    static const uint8_t round[4][3] = { { 0, 254, 0 }, { 0, 254, 0 }, { 0, 0, 254 }, { 253, 0, 0 } };
    static const int turns[4] = { 1, 6, 3, 8 };
    lt_arena *arena = lt_arena_new();
    lt_image img, stored;

    setenv("PALMAR_MODULES", MODULES, 1);
    for (int k = 0; k < 4; k++) {
        first_frame(arena, turned_film(matrices[turns[k] - 1], matrices[0], 1), turns[k], &img);
        ck_assert(img.width == (k % 2 ? 32 : 48) && img.height == (k % 2 ? 48 : 32));
        check_corner(&img, 0, 0, round[(4 - k) % 4]);
        check_corner(&img, img.width - 1, 0, round[(5 - k) % 4]);
        check_corner(&img, img.width - 1, img.height - 1, round[(6 - k) % 4]);
        check_corner(&img, 0, img.height - 1, round[(7 - k) % 4]);
    }
    put_file(in_folder("turned.mp4"), film_turned, sizeof(film_turned));
    put_file(in_folder("turned.mkv"), film_turned_mkv, sizeof(film_turned_mkv));
    for (int k = 0; k < 2; k++) {
        first_frame(arena, in_folder(k ? "turned.mkv" : "turned.mp4"), 8, &img);
        for (int i = 0; i < 4; i++)
            check_corner(&img, i % 2 ? 31 : 0, i / 2 ? 47 : 0, film_turned_corners + 3 * i);
    }
    first_frame(arena, turned_film(matrices[0], matrices[0], 1), 1, &stored);
    first_frame(arena, turned_film(matrices[4], matrices[0], 1), 5, &img);      /* mirrored, as a front camera does */
    for (int i = 0; i < 32; i++)
        ck_assert_mem_eq(img.data + 3 * (i + 32 * i), stored.data + 3 * (i + 48 * i), 3);
    lt_arena_free(arena);
#endif
}
END_TEST

static lt_status read_film_head(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    (void)arena;
    put_file(in_folder("head"), bytes, n);
    return lt_film_head_read(in_folder("head")).orientation == 8 ? LT_OK : lt_error(LT_EFORMAT, "head: upright");
}

/* Whatever is in the file; and a film of which the end is missing is called that. */
START_TEST(bent)
{
    lt_film *f;

    check_flipped(read_film_head, film_turned, sizeof(film_turned), 3000);
    check_flipped(read_film_head, film_turned_mkv, 1000, 3000);
    for (size_t n = 0; n < sizeof(film_turned); n++)
        attempt(read_film_head, film_turned, n);
    put_file(in_folder("cut.mp4"), film_turned, sizeof(film_turned) - 700);
    ck_assert_int_gt(lt_film_head_read(in_folder("cut.mp4")).want_bytes, (int64_t)sizeof(film_turned) - 700);
#ifdef HAVE_OPENCV
    setenv("PALMAR_MODULES", MODULES, 1);
    check_error(lt_film_open(in_folder("cut.mp4"), &f), LT_EFORMAT, "it is cut off");
#endif
    check_error(lt_film_open(scratch_folder, &f), LT_EIO, "not a regular file");
}
END_TEST

#ifdef HAVE_OPENCV
/* Of a film that is given up nothing stays, and what was there does. */
static void check_given_up(lt_image frame)
{
    lt_film_writer *w;
    struct stat old;
    glob_t other;

    put_file(in_folder("old.mp4"), "old", 3);
    check_ok(lt_film_create(in_folder("old.mp4"), 64, 48, 12, &w));
    check_ok(lt_film_put(w, &frame));
    lt_film_abort(w);
    ck_assert(stat(in_folder("old.mp4"), &old) == 0 && old.st_size == 3);
    ck_assert_int_eq(glob(in_folder("old.mp4.*"), 0, NULL, &other), GLOB_NOMATCH);
}
#endif

/* What is written is read back, as near as its codec comes; frames of another size, and folders that are not there. */
START_TEST(written)
{
#ifdef HAVE_OPENCV
    lt_arena *arena = lt_arena_new();
    lt_film_writer *w;
    lt_image grey, other;
    lt_film *f;
    bool more = true;
    int n = 0;

    setenv("PALMAR_MODULES", MODULES, 1);
    check_ok(lt_image_init(arena, 64, 48, 3, 8, &grey));
    check_ok(lt_image_init(arena, 64, 50, 3, 8, &other));
    check_ok(lt_film_create(in_folder("w.mp4"), 64, 48, 12, &w));
    for (int i = 0; i < 5; i++) {
        memset(grey.data, 40 * (i + 1), 3 * 64 * 48);
        check_ok(lt_film_put(w, &grey));
    }
    check_error(lt_film_put(w, &other), LT_EINVAL, "a frame of 64 x 50 pixels, want 64 x 48");
    check_error(lt_film_open(in_folder("w.mp4"), &f), LT_EIO, "w.mp4");
    check_ok(lt_film_finish(w));
    check_ok(lt_film_open(in_folder("w.mp4"), &f));
    ck_assert_double_eq_tol(lt_film_fps(f), 12, 1e-6);
    for (;; n++) {
        lt_image frame;

        check_ok(lt_film_next(f, arena, &frame, &more));
        if (!more)
            break;
        ck_assert_int_eq(frame.width, 64);
        ck_assert_int_le(abs(frame.data[0] - 40 * (n + 1)), 8);
    }
    ck_assert_int_eq(n, 5);
    lt_film_close(f);
    check_error(lt_film_create(in_folder("none/w.mp4"), 64, 48, 12, &w), LT_EIO, "none/w.mp4: cannot write: No such");
    check_error(lt_film_create(in_folder("w.txt"), 64, 48, 12, &w), LT_EIO, "w.txt: no film can be written there");
    check_given_up(grey);
    lt_arena_free(arena);
#endif
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_unchecked_fixture(tc, make_scratch_folder, remove_scratch_folder);
    tcase_add_test(tc, frames);
    tcase_add_test(tc, orientations);
    tcase_add_test(tc, upright);
    tcase_add_test(tc, bent);
    tcase_add_test(tc, written);
}

int main(void)
{
    return run_suite("film", add_tests);
}
