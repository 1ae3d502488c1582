/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of persons: rows that come back, the set, and what cannot be. */
#include "data/body/set.h"
#include "libtensor/io/array/npz.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"

#include <math.h>
#include <unistd.h>

enum { ROWS = 3 };

static lt_arena *arena;
static body_row row[ROWS];

static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
    memset(row, 0, sizeof(row));
    for (int i = 0; i < ROWS; i++) {
        row[i].K[0][0] = row[i].K[1][1] = 300;
        row[i].nodes_3d[0][2] = 1.5f;
        row[i].pose[54][2] = (float)i + 0.25f;
        row[i].seen[64] = BODY_IN_PICTURE;
        row[i].boxes[2][3] = -7;
        row[i].subject = i ? 5 : 9;
        row[i].holds[1] = 21;
        row[i].sits = i == 2;
    }
}

static void teardown(void)
{
    lt_arena_free(arena);
    remove_scratch_folder();
}

static void write_rows(void)
{
    check_ok(body_rows_write(arena, in_folder("train.npz"), row, ROWS));
}

START_TEST(rows_come_back)
{
    body_set set;

    ck_assert(!body_set_probe(scratch_folder));
    write_rows();
    check_ok(lt_write_file(in_folder("body.npz"), "x", 1));
    check_ok(lt_write_file(in_folder("manifest.json"), "{\"synthetic\": true}", 19));
    ck_assert(body_set_probe(scratch_folder));
    check_ok(body_set_open(arena, scratch_folder, "train", &set));
    ck_assert_int_eq(set.n, ROWS);
    ck_assert_int_eq(set.subjects, 2);
    ck_assert(set.synthetic);
    ck_assert_mem_eq(set.row, row, sizeof(row));
    check_error(body_set_open(arena, scratch_folder, "evaluation", &set), LT_EIO, "evaluation.npz: No such file");
    check_ok(body_rows_write(arena, in_folder("train.npz"), row, 0));
    check_error(body_set_open(arena, scratch_folder, "train", &set), LT_EFORMAT, "train.npz: has no rows");
}
END_TEST

static void write_picture(int width, int height)
{
    lt_image img;

    check_ok(lt_image_init(arena, width, height, 3, 8, &img));
    check_ok(lt_jpeg_write(in_folder("train/000002.jpg"), &img, 90));
}

START_TEST(pictures)
{
    body_set set;
    lt_image img;

    write_rows();
    check_ok(lt_make_dirs(in_folder("train")));
    check_ok(body_set_open(arena, scratch_folder, "train", &set));
    write_picture(192, 256);
    check_ok(body_set_picture(&set, 1, arena, &img));
    ck_assert_int_eq(img.height, BODY_PICTURE_HEIGHT);
    write_picture(256, 192);
    check_error(body_set_picture(&set, 1, arena, &img), LT_EFORMAT,
                "train/000002.jpg: is 256 x 192 with 3 channels of 8 bits, expected 192 x 256");
    check_error(body_set_picture(&set, 0, arena, &img), LT_EIO, "train/000001.jpg: No such file");
}
END_TEST

static lt_status parse(const uint8_t *bytes, size_t n)
{
    body_row *out;
    int64_t rows;

    return body_rows_parse(arena, "train.npz", bytes, n, &out, &rows);
}

START_TEST(cut_off_anywhere)
{
    uint8_t *bytes;
    size_t n;

    write_rows();
    check_ok(lt_read_file(arena, in_folder("train.npz"), LT_FILE_MAX, &bytes, &n));
    check_ok(parse(bytes, n));
    for (size_t cut = 0; cut < n; cut += 1 + cut / 16)
        check_error(parse(bytes, cut), LT_EFORMAT, "train.npz: ");
}
END_TEST

/* One number that cannot be */
static void check_row(const char *reason)
{
    uint8_t *bytes;
    size_t n;

    write_rows();
    check_ok(lt_read_file(arena, in_folder("train.npz"), LT_FILE_MAX, &bytes, &n));
    check_error(parse(bytes, n), LT_EFORMAT, reason);
    teardown();
    setup();
}

START_TEST(numbers_that_cannot_be)
{
    row[1].nodes_2d[64][1] = NAN;
    check_row("train.npz: \"nodes_2d\" of picture 2: a number is not finite");
    row[2].K[1][1] = 0;
    check_row("train.npz: \"K\" of picture 3: focal lengths are 300 and 0, expected more than 0");
    row[0].nodes_3d[0][2] = -1;
    check_row("train.npz: \"nodes_3d\" of picture 1: the pelvis is -1 m before the camera");
    row[0].holds[0] = 22;
    check_row("train.npz: \"holds\" of picture 1: object 22, expected at most 21");
}
END_TEST

/* The file again, with its first array in another way, or without the second one */
static void check_arrays(void (*change)(lt_npz *), const char *reason)
{
    lt_npz npz;
    uint8_t *bytes;
    size_t n;

    write_rows();
    check_ok(lt_npz_read(arena, in_folder("train.npz"), &npz));
    change(&npz);
    check_ok(lt_npz_write(in_folder("changed.npz"), npz.entry, npz.n, true));
    check_ok(lt_read_file(arena, in_folder("changed.npz"), LT_FILE_MAX, &bytes, &n));
    check_error(parse(bytes, n), LT_EFORMAT, reason);
}

static void lacks_one(lt_npz *npz) { npz->entry[1].name = "shapes"; }
static void fewer_rows(lt_npz *npz) { npz->entry[0].array.shape[0] = 2; }
static void fewer_joints(lt_npz *npz) { npz->entry[0].array.shape[1] = 24; }
static void other_numbers(lt_npz *npz) { npz->entry[3].array.type = LT_ELEM_I4; }
static void one_number(lt_npz *npz) { npz->entry[0].array.rank = 0; }

START_TEST(arrays_that_cannot_be)
{
    check_arrays(lacks_one, "\"shape\"");
    check_arrays(fewer_rows, "\"shape\" is f4 (3, 10), expected f4 (2, 10)");
    check_arrays(fewer_joints, "\"pose\" is f4 (3, 24, 3), expected f4 (3, 55, 3)");
    check_arrays(other_numbers, "\"trans\" is i4 (3, 3), expected f4 (3, 3)");
    check_arrays(one_number, "\"pose\" is f4 (), expected f4 (0, 55, 3)");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, rows_come_back);
    tcase_add_test(tc, pictures);
    tcase_add_test(tc, cut_off_anywhere);
    tcase_add_test(tc, numbers_that_cannot_be);
    tcase_add_test(tc, arrays_that_cannot_be);
}

int main(void)
{
    return run_suite("body set", add_tests);
}
