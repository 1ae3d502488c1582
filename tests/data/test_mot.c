/* SPDX-License-Identifier: Apache-2.0 */
/* MOTChallenge's files: rows as the challenges and we have them, folders of sequences, and what cannot be. */
#include "data/mot/mot.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"

static lt_arena *arena;

static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
}

static void teardown(void)
{
    lt_arena_free(arena);
    remove_scratch_folder();
}

static lt_status parse(const char *text, mot_kind kind, int64_t frames, mot_frame **out)
{
    return mot_parse(arena, "x.txt", lt_arena_strdup(arena, text), strlen(text), kind, frames, out);
}

static void put(const char *path, const char *text)
{
    const char *at = in_folder(path);

    check_ok(lt_make_dirs(lt_path_folder(arena, at)));
    put_file(at, text, strlen(text));
}

/* ---- rows ---- */

START_TEST(truth)
{
    mot_frame *f;

    check_ok(parse("2,7,11,21,30,40,0,8,0.25\n1,3,1,1,10,20,1,1,1\n\n2,3,2,3,10,20,1,1,.5\r\n", MOT_TRUTH, 3, &f));
    ck_assert_int_eq(f[0].n, 1);
    ck_assert_int_eq(f[1].n, 2);
    ck_assert_int_eq(f[2].n, 0);
    ck_assert_int_eq(f[0].box[0].id, 3);
    ck_assert_double_eq(f[0].box[0].box[0], 0);
    ck_assert_double_eq(f[0].box[0].box[3], 20);
    ck_assert_int_eq(f[1].box[0].id, 7);
    ck_assert(!f[1].box[0].scored && f[1].box[1].scored);
    ck_assert_int_eq(f[1].box[0].cls, 8);
    ck_assert_double_eq(f[1].box[0].visible, 0.25);
    ck_assert_double_eq(f[1].box[0].box[2], 40);
}
END_TEST

/* MOT15 has places in the world where the others have a class. */
START_TEST(truth_of_2015)
{
    mot_frame *f;

    check_ok(parse("1,1,912,484,97,109,0,-1,-1,-1\n1,2,912,484,97,109,1,4.5,-20,0\n", MOT_TRUTH, 1, &f));
    ck_assert_int_eq(f[0].n, 2);
    ck_assert(!f[0].box[0].scored && f[0].box[1].scored);
    ck_assert_int_eq(f[0].box[1].cls, MOT_PEDESTRIAN);
}
END_TEST

START_TEST(detections)
{
    mot_frame *f;

    check_ok(parse("1, -1, 1359.1, 413.27, 120.26, 362.77, 2.3092, -1, -1, -1\n1,-1,5,6,7,8,-.5", MOT_DETECTIONS, 1,
                   &f));
    ck_assert_int_eq(f[0].n, 2);
    ck_assert_double_eq(f[0].box[0].score, 2.3092);
    ck_assert_double_eq(f[0].box[1].score, -0.5);
    ck_assert_double_eq_tol(f[0].box[0].box[2], 1358.1 + 120.26, 1e-9);
}
END_TEST

/* What is written is read; numbers that NumPy wrote are whole all the same. */
START_TEST(results)
{
    const mot_box two[] = { { .id = 4, .box = { 0.5, 1.25, 10, 20 }, .score = 0.875 },
                            { .id = 5, .box = { -3, 0, 4, 9 } } };
    const mot_frame frames[] = { { NULL, 0 }, { two, 2 } };
    const char *path = in_folder("r.txt");
    mot_frame *f;

    check_ok(mot_write(path, frames, 2));
    check_ok(mot_read(arena, path, MOT_RESULTS, 2, &f));
    ck_assert_int_eq(f[0].n, 0);
    ck_assert_int_eq(f[1].n, 2);
    ck_assert_int_eq(f[1].box[0].id, 4);
    for (int c = 0; c < 4; c++)
        ck_assert_double_eq_tol(f[1].box[1].box[c], two[1].box[c], 1e-9);
    ck_assert_double_eq(f[1].box[0].score, 0.875);
    check_ok(parse("1.000000000000000000e+00,2.0e+00,1,2,3,4\n", MOT_RESULTS, 1, &f));
    ck_assert_int_eq(f[0].box[0].id, 2);
    ck_assert_double_eq(f[0].box[0].score, 1);
}
END_TEST

static const struct { const char *text; mot_kind kind; const char *reason; } wrong[] = {
    { "1,1,2,3,4,5,1,1\n", MOT_TRUTH, "x.txt:1: 8 columns, expected 9 of the truth" },
    { "\n1,1,2,3,4\n", MOT_RESULTS, "x.txt:2: 5 columns, expected 6 of results" },
    { "1,1,2,3,4,5,1,1,1,1,1\n", MOT_RESULTS, "more than 10 columns" },
    { "0,1,2,3,4,5\n", MOT_RESULTS, "frame 0, expected a whole number from 1 to 3" },
    { "4,1,2,3,4,5\n", MOT_RESULTS, "frame 4, expected" },
    { "1.5,1,2,3,4,5\n", MOT_RESULTS, "frame 1.5, expected" },
    { "1,1e17,2,3,4,5\n", MOT_RESULTS, "id 1e+17, expected" },
    { "1,1,nan,3,4,5\n", MOT_RESULTS, "\"nan,3,4,5\" is no number" },
    { "1,1,1e12,3,4,5\n", MOT_RESULTS, "1e+12, expected pixels" },
    { "1,1,2 3,4,5,6\n", MOT_RESULTS, "\"3,4,5,6\", expected a comma" },
    { "1,1,2,3,4,\n", MOT_RESULTS, "\"\" is no number" },
    { "1,1,2,3,4,5,1,14,1\n", MOT_TRUTH, "class 14, expected a whole number from 1 to 13" },
    { "1,-1,2,3,4,5\n", MOT_DETECTIONS, "6 columns, expected 7 of detections" },
};

START_TEST(wrong_rows)
{
    mot_frame *f;

    check_error(parse(wrong[_i].text, wrong[_i].kind, 3, &f), LT_EFORMAT, wrong[_i].reason);
}
END_TEST

/* Cut anywhere, a file is read or refused. */
START_TEST(cut)
{
    static const char text[] = "1,3,426,78,39,94,1,1,0.9619\n2,7,1.5,-2e1,53,127,0,12,0\n\0";

    for (size_t n = 0; n < sizeof(text); n++) {
        char *copy = lt_arena_alloc(arena, n + 1);
        mot_frame *f;
        lt_status st;

        memcpy(copy, text, n);
        st = mot_parse(arena, "x.txt", copy, n, MOT_TRUTH, 2, &f);
        ck_assert(st == LT_OK || st == LT_EFORMAT);
    }
}
END_TEST

/* ---- sequences ---- */

static const char info[] = "[Sequence]\nname=whatever\nimDir=../b/img1\nframeRate=25\nseqLength=2\nimWidth=1920\n"
                           "imHeight=1080\nimExt=.png\n";

START_TEST(sets)
{
    mot_set s;

    put("set/train/b10/seqinfo.ini", info);
    put("set/train/b2/seqinfo.ini", "[Sequence]\r\nFrameRate = 14 \r\nseqlength=2\r\nimWidth=64\r\nimHeight=48\r\n");
    put("set/train/b2/gt/gt.txt", "");
    put("set/train/b2/times.csv", "frame,time\n1,0.5\n2,0.75\n");
    put("set/train/readme.txt", "");
    check_ok(mot_open(arena, in_folder("set"), "train", &s));
    ck_assert_int_eq(s.n, 2);
    ck_assert(!s.synthetic);
    ck_assert_str_eq(s.sequence[0].name, "b2");
    ck_assert_str_eq(s.sequence[1].name, "b10");
    ck_assert_double_eq(s.sequence[0].time[1], 0.75);
    ck_assert_double_eq(s.sequence[1].time[1], 1 / 25.0);
    ck_assert(s.sequence[0].truth && !s.sequence[0].detections && !s.sequence[1].truth);
    ck_assert_str_eq(mot_picture(arena, &s.sequence[0], 1), in_folder("set/train/b2/img1/000002.jpg"));
    ck_assert_str_eq(mot_picture(arena, &s.sequence[1], 0), in_folder("set/train/b10/../b/img1/000001.png"));
    ck_assert_int_eq(s.sequence[1].width, 1920);
    ck_assert(mot_probe(in_folder("set")) && mot_probe(in_folder("set/train")) && mot_probe(in_folder("set/train/b2")));
    check_ok(mot_open(arena, in_folder("set/train"), "evaluation", &s));
    ck_assert_int_eq(s.n, 2);
    put("set/manifest.json", "{\"synthetic\": true}");
    check_ok(mot_open(arena, in_folder("set/train/b2/"), "train", &s));
    ck_assert_str_eq(s.sequence[0].name, "b2");
    check_ok(mot_open(arena, in_folder("set"), "train", &s));
    ck_assert(s.synthetic);
}
END_TEST

START_TEST(wrong_sets)
{
    mot_sequence q;
    mot_set s;

    check_error(mot_open(arena, in_folder("none"), "train", &s), LT_EIO, "No such file");
    put("set/other.txt", "");
    ck_assert(!mot_probe(in_folder("set")));
    check_error(mot_open(arena, in_folder("set"), "train", &s), LT_EIO,
                "no sequences: no folder in it has a seqinfo.ini");
    put("a/seqinfo.ini", "[Sequence]\nframeRate=30\nimWidth=4\nimHeight=4\n");
    check_error(mot_sequence_open(arena, in_folder("a"), &q), LT_EFORMAT, "a/seqinfo.ini: lacks seqLength");
    put("a/seqinfo.ini", "frameRate=30\nseqLength=-4\n");
    check_error(mot_sequence_open(arena, in_folder("a"), &q), LT_EFORMAT,
                "seqinfo.ini:2: seqLength is \"-4\", expected");
    put("a/seqinfo.ini", "seqLength=1e18\n");
    check_error(mot_sequence_open(arena, in_folder("a"), &q), LT_EFORMAT, "at most 1e+06");
    put("a/seqinfo.ini", info);
    put("a/times.csv", "frame,time\n1,0\n");
    check_error(mot_sequence_open(arena, in_folder("a"), &q), LT_EFORMAT, "times.csv: has 1 frames, seqinfo.ini 2");
    put("a/times.csv", "frame,time\n1,0\n3,1\n");
    check_error(mot_sequence_open(arena, in_folder("a"), &q), LT_EFORMAT, "times.csv:3: \"3,1\", expected frame 2");
    put("a/times.csv", "frame,time\n1,0\n2,1\n3,2\n");
    check_error(mot_sequence_open(arena, in_folder("a"), &q), LT_EFORMAT, "times.csv:4: more than the 2 frames");
}
END_TEST

/* ---- looks ---- */

static lt_status parse_looks(const char *text, mot_looks *out)
{
    return mot_parse_looks(arena, "identities.csv", lt_arena_strdup(arena, text), strlen(text), out);
}

static const char persons[] = "person,split,shape,clothes,left_hand,right_hand\n";

/* The second has the first one's clothes, the third his own of both. */
START_TEST(looks)
{
    mot_looks l;

    put("set/identities.csv", lt_arena_printf(arena, "%s1,train,1,1,1,2\r\n2,train,2,1,3,4\n\n3,evaluation,3,3,5,6",
                                              persons));
    check_ok(mot_read_looks(arena, in_folder("set"), &l));
    ck_assert_int_eq(l.n, 3);
    ck_assert_int_eq(mot_look(&l, "hall-01_person", 1), mot_look(&l, "hall-01_person", 2));
    ck_assert_int_ne(mot_look(&l, "hall-01_person", 1), mot_look(&l, "hall-01_person", 3));
    ck_assert_int_eq(mot_look(&l, "table-01_hand", 4), mot_look(&l, "table-02_hand", 1));
    ck_assert_int_ne(mot_look(&l, "table-01_hand", 6), mot_look(&l, "table-01_hand", 1));
    ck_assert_int_eq(mot_look(&l, "table-01_object", 2), 2);
    ck_assert_int_eq(mot_look(&l, "hall-01_person", 9), 9);
    check_ok(mot_read_looks(arena, in_folder("none"), &l));
    ck_assert_int_eq(l.n, 0);
    ck_assert_int_eq(mot_look(&l, "MOT17-02", 7), 7);
}
END_TEST

START_TEST(wrong_looks)
{
    mot_looks l;

    check_error(parse_looks("person\n1\n", &l), LT_EFORMAT, "identities.csv:1: \"person\", expected person,split,");
    check_error(parse_looks(lt_arena_printf(arena, "%s1,train,x,1,1,2\n", persons), &l), LT_EFORMAT,
                "identities.csv:2: column 3 is \"x\", expected a whole number from 1 on");
    check_error(parse_looks(lt_arena_printf(arena, "%s1,train,1,1,1,2.5\n", persons), &l), LT_EFORMAT, "column 6 is");
    check_error(parse_looks(lt_arena_printf(arena, "%s\n1,train,1,1,1,2,3\n", persons), &l), LT_EFORMAT,
                "identities.csv:3: expected 6 columns: person,split,shape");
    check_error(parse_looks(lt_arena_printf(arena, "%s1,train\n", persons), &l), LT_EFORMAT, "expected 6 columns");
    check_error(mot_parse_looks(arena, "identities.csv", (char[3]){ 'a', 0, 0 }, 2, &l), LT_EFORMAT, "a NUL character");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, truth);
    tcase_add_test(tc, truth_of_2015);
    tcase_add_test(tc, detections);
    tcase_add_test(tc, results);
    tcase_add_loop_test(tc, wrong_rows, 0, (int)LT_COUNT(wrong));
    tcase_add_test(tc, cut);
    tcase_add_test(tc, sets);
    tcase_add_test(tc, wrong_sets);
    tcase_add_test(tc, looks);
    tcase_add_test(tc, wrong_looks);
}

int main(void)
{
    return run_suite("mot", add_tests);
}
