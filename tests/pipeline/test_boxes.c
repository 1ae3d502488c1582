/* SPDX-License-Identifier: Apache-2.0 */
/* Boxes of a detector as CSV: what is read, each thing that is wrong, cut and damaged files, and little memory. */
#include "pipeline/boxes.h"
#include "tests/io/hostile.h"
#include "tests/suite.h"

#define HEADER "image,hand_x0,hand_y0,hand_x1,hand_y1"
#define ALL HEADER ",object_x0,object_y0,object_x1,object_y1,side"

static lt_status read_bytes(lt_arena *arena, const uint8_t *bytes, size_t n)
{
    predict_boxes b;

    put_file(in_folder("boxes.csv"), bytes, n);
    return predict_boxes_read(arena, in_folder("boxes.csv"), &b);
}

static predict_boxes read_text(lt_arena *arena, const char *text)
{
    predict_boxes b;

    put_file(in_folder("boxes.csv"), text, strlen(text));
    check_ok(predict_boxes_read(arena, in_folder("boxes.csv"), &b));
    return b;
}

static void check_box(crop_box b, float x0, float y0, float x1, float y1)
{
    ck_assert_float_eq(b.x0, x0);
    ck_assert_float_eq(b.y0, y0);
    ck_assert_float_eq(b.x1, x1);
    ck_assert_float_eq(b.y1, y1);
}

START_TEST(values)
{
    lt_arena *arena = lt_arena_new();
    const predict_boxes b = read_text(arena, ALL "\nb.png,1,2,3.5,4e1,-5,6,7,8,left\n\na,10,20,30,40,,,,,\n"
                                             "film.mp4#12,,,,,1,2,3,4,Right\n");

    ck_assert_uint_eq(b.n, 3);
    ck_assert_ptr_null(b.unread);
    ck_assert_str_eq(b.row[0].image, "a");
    ck_assert_int_eq(b.row[0].line, 4);
    ck_assert(b.row[0].has_hand && !b.row[0].has_object && b.row[0].side == PREDICT_ANY_SIDE);
    check_box(b.row[0].hand, 10, 20, 30, 40);
    ck_assert_str_eq(b.row[1].image, "b.png");
    ck_assert_int_eq(b.row[1].line, 2);
    ck_assert_int_eq(b.row[1].side, PREDICT_LEFT);
    check_box(b.row[1].hand, 1, 2, 3.5f, 40);
    check_box(b.row[1].object, -5, 6, 7, 8);
    ck_assert_str_eq(b.row[2].image, "film.mp4#12");
    ck_assert(!b.row[2].has_hand && b.row[2].has_object && b.row[2].side == PREDICT_RIGHT);
    ck_assert_int_eq(b.row[2].input, -1);
    lt_arena_free(arena);
}
END_TEST

/* Columns in another order and foreign ones, a byte order mark, quotes, blanks, lines as Windows ends them, and no
 * newline behind the last. */
START_TEST(as_others_write_them)
{
    lt_arena *arena = lt_arena_new();
    const predict_boxes b = read_text(arena, "\xef\xbb\xbfscore,hand_y1,hand_x1, hand_y0 ,\"hand_x0\",image,class\r\n"
                                             "0.9,4, 3,\"2\",1,\"a, \"\"b\"\".png\",hand\r\n,40,30,20,10,c.png,");

    ck_assert_uint_eq(b.n, 2);
    ck_assert_str_eq(b.unread, "score");
    ck_assert_str_eq(b.row[0].image, "a, \"b\".png");
    check_box(b.row[0].hand, 1, 2, 3, 4);
    check_box(b.row[1].hand, 10, 20, 30, 40);
    lt_arena_free(arena);
}
END_TEST

START_TEST(wrong)
{
    static const struct { const char *text, *reason; } cases[] = {
        { "", "boxes.csv:1: no column image; want image,hand_x0,hand_y0,hand_x1,hand_y1" },
        { "a.png,1,2,3,4\n", "boxes.csv:1: no column image" },
        { "image;hand_x0;hand_y0;hand_x1;hand_y1\n", "boxes.csv:1: no column image" },
        { "image,hand_x0,hand_y0,hand_x1\n", "boxes.csv:1: no column hand_y1" },
        { HEADER ",object_x0\na,1,2,3,4,5\n", "boxes.csv:1: no column object_y0" },
        { HEADER ",image\n", "boxes.csv:1: two columns are called image" },
        { HEADER "\n", "boxes.csv:1: no lines" },
        { HEADER "\na,1,2,3\n", "boxes.csv:2: found 4 cells, the first line names 5 columns" },
        { HEADER "\na,1,2,3,4\n\nb,1,2,3,4,5\n", "boxes.csv:4: found 6 cells" },
        { HEADER "\n\"a,1,2,3,4\n", "boxes.csv:2: found 1 cells" },
        { HEADER "\n,1,2,3,4\n", "boxes.csv:2: the image's name is empty" },
        { HEADER "\nin/a,1,2,3,4\n", "boxes.csv:2: image is \"in/a\", want a file's name without its folder" },
        { HEADER "\na,1,2,3x,4\n", "boxes.csv:2: hand_x1 is \"3x\", want a number" },
        { HEADER "\na,nan,2,3,4\n", "boxes.csv:2: hand_x0 is \"nan\", want a number" },
        { HEADER "\na,1,2,inf,4\n", "boxes.csv:2: hand_x1 is \"inf\", want a number" },
        { HEADER "\na,1,2,3,1e9\n", "boxes.csv:2: hand_y1 is \"1e9\", want a number" },
        { HEADER "\na,1,2,,4\n", "boxes.csv:2: hand_x1 is \"\", want a number of pixels, or nothing in all four" },
        { HEADER "\na,3,2,1,4\n", "boxes.csv:2: an empty box 3,2,1,4; want hand_x0 left of hand_x1" },
        { HEADER "\na,1,2,3,2\n", "boxes.csv:2: an empty box 1,2,3,2" },
        { HEADER "\na,999999,2,999999.001,3\n", "boxes.csv:2: an empty box" },
        { ALL "\na,1,2,3,4,5,6,5,8,\n", "boxes.csv:2: an empty box 5,6,5,8; want object_x0 left of object_x1" },
        { ALL "\na,1,2,3,4,,,,,both\n", "boxes.csv:2: side is \"both\", want left, right or nothing" },
    };

    for (size_t i = 0; i < LT_COUNT(cases); i++)
        check_refused(read_bytes, cases[i].text, strlen(cases[i].text), cases[i].reason);
    check_refused(read_bytes, HEADER "\na\0,1,2,3,4\n", sizeof(HEADER) + 11, "found a NUL byte");
    ck_assert_int_eq(predict_boxes_read(NULL, in_folder("none.csv"), &(predict_boxes){ 0 }), LT_EIO);
}
END_TEST

static const char sample[] = ALL ",score\na.png,1,2,30,40,,,,,left,0.9\n\"b, c\",10,20,30,40,11,12,13,14,,1\n";

/* A file may end anywhere and be sound; what is read of it is. */
START_TEST(cut)
{
    for (size_t n = 0; n < sizeof(sample); n++)
        attempt(read_bytes, (const uint8_t *)sample, n);
}
END_TEST

START_TEST(damaged)
{
    check_flipped(read_bytes, (const uint8_t *)sample, sizeof(sample) - 1, 3000);
}
END_TEST

START_TEST(random_bytes)
{
    static const char often[] = ",,,,\n\n\"\r 0123456789.-eax#_";
    lt_rng rng = lt_rng_make(7, 1);
    uint8_t bytes[sizeof(HEADER) + 300] = HEADER "\n";

    for (int t = 0; t < 3000; t++) {
        const size_t n = sizeof(HEADER) + lt_rng_below(&rng, 300);

        for (size_t i = sizeof(HEADER); i < n; i++)
            bytes[i] = t % 2 ? (uint8_t)often[lt_rng_below(&rng, sizeof(often) - 1)]
                             : (uint8_t)lt_rng_below(&rng, 256);
        attempt(read_bytes, bytes, n);
    }
}
END_TEST

START_TEST(without_memory)
{
    ck_assert_int_gt(check_without_memory(read_bytes, (const uint8_t *)sample, sizeof(sample) - 1), 0);
}
END_TEST

/* Lines without anything in them, and the shortest with: both take little more than the file. */
START_TEST(memory)
{
    enum { N = 60000 };
    static char text[6 * N + 100];
    lt_arena *arena = lt_arena_new();
    char *end = stpcpy(text, HEADER "\na,1,2,3,4\n");

    memset(end, '\n', N);
    read_text(arena, text);
    ck_assert_uint_lt(lt_arena_bytes(arena), 16 * N + (1 << 20));
    lt_arena_free(arena);
    arena = lt_arena_new();
    for (int i = 0; i < N; i++)
        end = stpcpy(end, "a,,,,\n");
    check_ok(read_bytes(arena, (const uint8_t *)text, strlen(text)));
    ck_assert_uint_lt(lt_arena_bytes(arena), 16 * strlen(text) + (1 << 20));
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *t)
{
    tcase_add_checked_fixture(t, make_scratch_folder, remove_scratch_folder);
    tcase_set_timeout(t, 60);
    tcase_add_test(t, values);
    tcase_add_test(t, as_others_write_them);
    tcase_add_test(t, wrong);
    tcase_add_test(t, cut);
    tcase_add_test(t, damaged);
    tcase_add_test(t, random_bytes);
    tcase_add_test(t, without_memory);
    tcase_add_test(t, memory);
}

int main(void)
{
    return run_suite("predict_boxes", add_tests);
}
