/* SPDX-License-Identifier: Apache-2.0 */
/* Clips of actions: what a folder has, windows of it and who is on which side, and what cannot be. */
#include "data/action/takes.h"
#include "data/action/windows.h"
#include "data/recording/clips.h"
#include "data/recording/recording.h"
#include "libtensor/io/array/npy.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "tests/scratch.h"

#include <math.h>
#include <stdlib.h>

enum { CLIPS = 4, LENGTH = 6, T = 3 };

static float body[CLIPS][3][LENGTH][ACTION_BODY], hand_object[CLIPS][3][LENGTH][ACTION_HAND_OBJECT];
static uint8_t valid[CLIPS][LENGTH];

static void write_arrays(void)
{
    const lt_array b = lt_array_make(LT_ELEM_F4, 5, (int64_t[]){ CLIPS, 3, LENGTH, ACTION_BODY, 1 }, body);
    const lt_array h = lt_array_make(LT_ELEM_F4, 4, (int64_t[]){ CLIPS, 3, LENGTH, ACTION_HAND_OBJECT }, hand_object);
    const lt_array v = lt_array_make(LT_ELEM_U1, 2, (int64_t[]){ CLIPS, LENGTH }, valid);

    check_ok(lt_npy_write(at("body.npy"), &b));
    check_ok(lt_npy_write(at("hand_object.npy"), &h));
    check_ok(lt_npy_write(at("valid.npy"), &v));
}

static void write_labels(const char *text)
{
    check_ok(lt_write_file(at("label.json"), text, strlen(text)));
}

/* Place, clip, coordinate and frame can be told from a number. */
static void setup(void)
{
    open_scratch();
    for (int n = 0; n < CLIPS; n++)
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < LENGTH; k++) {
                for (int i = 0; i < ACTION_BODY; i++)
                    body[n][c][k][i] = (float)(1000 * n + 100 * c + 10 * k) + (float)i / 128;
                for (int i = 0; i < ACTION_HAND_OBJECT; i++)
                    hand_object[n][c][k][i] = (float)(10 * k * k) + (float)i / 32;
            }
    memset(valid, 0, sizeof(valid));
    write_arrays();
    write_labels("{\"names\": [\"a\", \"b\", \"c\", \"d\"], \"labels\": [0, 9, 6, 2], \"subject\": [0, 1, 1, 2], "
                 "\"onset\": [0, 1, -1, 0], \"frames\": [6, 5, 2, 6]}");
}

START_TEST(clips)
{
    action_set s;

    ck_assert(action_probe(scratch_folder));
    check_ok(action_open(arena, scratch_folder, &s));
    ck_assert_int_eq(s.n, CLIPS);
    ck_assert_int_eq(s.length, LENGTH);
    ck_assert_int_eq(s.subjects, 3);
    ck_assert_str_eq(s.clip[1].name, "b");
    ck_assert_int_eq(s.clip[1].cls, 9);
    ck_assert_int_eq(s.clip[2].frames, 2);
    ck_assert_int_eq(s.clip[2].onset, -1);
    ck_assert(!s.synthetic && isnan(s.difficulty));
}
END_TEST

/* A frame in which nobody is seen holds the last one; the first ones, the first that is there. */
START_TEST(nobody_is_seen)
{
    const size_t frame = ACTION_BODY;
    action_set s;

    body[0][1][0][7] = NAN;
    body[0][2][3][64] = INFINITY;
    write_arrays();
    check_ok(action_open(arena, scratch_folder, &s));
    ck_assert_float_eq(s.body[0], 10);
    ck_assert_float_eq(s.body[3 * frame], 20);
    ck_assert_float_eq(s.body[(2 * LENGTH + 3) * frame], 220);
    ck_assert_float_eq(s.body[4 * frame], 40);
    for (int k = 0; k < 2; k++)
        body[2][0][k][0] = NAN;
    write_arrays();
    check_error(action_open(arena, scratch_folder, &s), LT_EFORMAT, "clip c: nobody is seen in any of its 2 frames");
}
END_TEST

static int64_t windows(const action_set *s, action_window_options how, const action_window **w)
{
    int64_t n;

    check_ok(action_windows(arena, s, &how, w, &n));
    return n;
}

START_TEST(sides)
{
    action_window_options how = { .frames = T, .per_clip = 4, .held_out = -1 };
    const action_window *w;
    action_set s;
    int64_t n, both = 0;

    check_ok(action_open(arena, scratch_folder, &s));
    n = windows(&s, how, &w);
    ck_assert_int_eq(n, 12);
    ck_assert_int_eq(w[3].start, 3);                /* of six frames the last three */
    ck_assert_int_eq(w[5].start, 1);                /* of five 0, 2/3, 4/3, 2 */
    ck_assert_int_eq(w[11].start, 0);               /* of two */
    how.evaluation = true;
    n = windows(&s, how, &w);
    ck_assert_int_eq(n, 4);
    ck_assert_int_eq(w[0].clip, 3);
    how.held_out = 1;
    ck_assert_int_eq(windows(&s, how, &w), 8);
    how = (action_window_options){ .frames = T, .per_clip = 100, .split = ACTION_AT_RANDOM, .held_out = 5 };
    both = windows(&s, how, &w);
    how.evaluation = true;
    n = windows(&s, how, &w);
    ck_assert_int_eq(both + n, 400);
    ck_assert_int_gt(n, 90);
    ck_assert_int_lt(n, 180);
    how = (action_window_options){ .frames = T, .per_clip = 1, .held_out = 7, .evaluation = true };
    check_error(action_windows(arena, &s, &how, &w, &n), LT_EINVAL, "no clip to score: subject 7 is held out, and 3");
}
END_TEST

START_TEST(a_window)
{
    float b[3][T][ACTION_BODY], h[3][T][ACTION_HAND_OBJECT], v[T];
    action_set s;

    valid[0][2] = valid[0][3] = 1;
    valid[2][0] = 1;
    hand_object[0][1][3][29] = NAN;
    write_arrays();
    check_ok(action_open(arena, scratch_folder, &s));
    ck_assert_int_eq(action_window_read(&s, &(action_window){ 0, 1 }, T, b[0][0], h[0][0], v), 1);
    ck_assert_float_eq(b[1][0][0], 0);
    ck_assert_float_eq(b[1][2][64], 20.5f);
    ck_assert(v[0] == 0 && v[1] == 1 && v[2] == 0);
    ck_assert_float_eq(h[0][1][0], 0);              /* less the wrist of the first valid frame */
    ck_assert_float_eq(h[2][1][16], 0.5f);
    ck_assert_float_eq(h[0][2][16], 0);
    ck_assert_int_eq(action_window_read(&s, &(action_window){ 2, 0 }, T, b[0][0], h[0][0], v), 1);
    ck_assert_float_eq(b[0][2][0], 10);             /* the second frame again: there are no more */
}
END_TEST

static const struct { const char *text, *reason; } bad[] = {
    { "{\"labels\": [0, 1, 2], \"subject\": [0, 0, 0, 0]}",
      "\"labels\" has 3 numbers, expected one for each of 4 clips" },
    { "{\"labels\": [0, 1, 2, 3, 4], \"subject\": [0, 0, 0, 0]}", "\"labels\" has 5 numbers" },
    { "{\"labels\": [0, 1, 2, 10], \"subject\": [0, 0, 0, 0]}", "labels[3]: expected a whole number from 0 to 9" },
    { "{\"labels\": [0, 1, 2, 3]}", "has no list \"subject\"" },
    { "{\"labels\": [0, 1, 2, 3], \"subject\": [0, 0, 0, 0.5]}", "subject[3]: expected a whole number from 0" },
    { "{\"labels\": [0, 1, 2, 3], \"subject\": [0, 0, 0, 0], \"frames\": [1, 2, 7, 3]}",
      "frames[2]: expected a whole" },
    { "{\"labels\": [0, 1, 2, 3], \"subject\": [0, 0, 0, 0], \"classes\": [\"waving\", \"flying\"]}",
      "classes[1] is \"flying\", expected \"walking\"" },
    { "[", "label.json:1:" },
};

START_TEST(bad_labels)
{
    action_set s;

    write_labels(bad[_i].text);
    check_error(action_open(arena, scratch_folder, &s), LT_EFORMAT, bad[_i].reason);
}
END_TEST

START_TEST(bad_arrays)
{
    const lt_array flat = lt_array_make(LT_ELEM_F4, 2, (int64_t[]){ CLIPS, 3 }, body);
    const lt_array few = lt_array_make(LT_ELEM_U1, 2, (int64_t[]){ 2, LENGTH }, valid);
    action_set s;

    check_ok(lt_npy_write(at("valid.npy"), &few));
    check_error(action_open(arena, scratch_folder, &s), LT_EFORMAT,
                "valid.npy: is u1 (2, 6), expected u1, a number for");
    check_ok(lt_npy_write(at("body.npy"), &flat));
    check_error(action_open(arena, scratch_folder, &s), LT_EFORMAT, "body.npy: is f4 (4, 3), expected f4 (N, 3, T, 65");
    check_error(action_open(arena, at("none"), &s), LT_EIO, "none/body.npy: No such file");
}
END_TEST

/* Where DexYCB's takes are cut: contact at 40, the object gone from its place at 50. */
START_TEST(cuts)
{
    static const action_cut want[ACTION_CUTS] = { { 2, 0, 40, false }, { 9, 25, 80, false }, { 8, 65, 99, false },
                                                  { 7, 25, 80, true } };
    action_cut c[ACTION_CUTS];

    ck_assert_int_eq(action_cut_take(&(action_take){ 40, 50, 100 }, c), ACTION_CUTS);
    for (int i = 0; i < ACTION_CUTS; i++)
        ck_assert(c[i].cls == want[i].cls && c[i].first == want[i].first && c[i].last == want[i].last &&
                  c[i].backwards == want[i].backwards);
    ck_assert_int_eq(action_cut_take(&(action_take){ 3, 50, 55 }, c), ACTION_CUTS);
    ck_assert(c[1].first == 0 && c[1].last == 54 && c[2].first == 54 && c[2].last == 54);
    ck_assert_int_eq(action_cut_take(&(action_take){ 3, -1, 55 }, c), 0);
    ck_assert_int_eq(action_cut_take(&(action_take){ -1, 5, 55 }, c), 0);
}
END_TEST

/* ---- what persons did before cameras ---- */

/* One person for 40 frames, 20 of each of two things; he is at (1, k / 100, 0.9), joint i is i mm beside that */
static void put_lines(const char *path, bool truth, double off, int frames)
{
    FILE *f = fopen(path, "w");

    for (int k = 0; k < frames; k++) {
        fprintf(f, truth ? "{\"schema\":\"palmar.set/1\",\"t\":%g,\"people\":[{\"id\":4,\"joints\":["
                         : "{\"schema\":\"palmar.set/1\",\"t\":[%g],\"people\":[{\"id\":9,\"joints\":[", k / 30.0);
        for (int i = 0; i < ACTION_BODY; i++)
            fprintf(f, "%s[%g,%g,0.9]", i ? "," : "", 1 + i / 1000.0 + off, k / 100.0);
        fprintf(f, "]}],\"action\":[{\"person\":%d,\"class\":\"%s\",\"p\":1,\"onset\":0}]}\n", truth ? 4 : 9,
                action_classes[k < 20 ? 2 : 7]);
    }
    fclose(f);
}

START_TEST(before_cameras)
{
    const recording_rig rig = { .n = 1, .fps = 30, .has_robot = true, .robot = { 0, 1, 0, 1 },
                                .camera = { { .name = "a", .width = 16, .height = 16, .K = { 9, 9, 8, 8 } } } };
    const action_window_options train = { .frames = 30, .per_clip = 2, .held_out = -1 };
    const action_window *window;
    action_set s, seen;
    int64_t n;

    check_ok(recording_rig_write(at("recording.json"), &rig));
    ck_assert(!recording_clips_probe(scratch_folder));
    put_lines(at("truth.ndjson"), true, 0, 40);
    ck_assert(recording_clips_probe(scratch_folder));
    check_ok(recording_clips_open(arena, scratch_folder, NULL, &s));
    ck_assert_int_eq(s.n, 2);
    ck_assert(s.clip[0].cls == 2 && s.clip[1].cls == 7 && s.clip[0].frames == 20);
    ck_assert_double_eq_tol(s.body[3], 1.003, 1e-6);            /* x: to the right of who looks along the world's y */
    ck_assert_double_eq_tol(s.body[20 * 65 + 65], -0.9, 1e-6);  /* y: down */
    ck_assert_double_eq_tol(s.body[2 * 20 * 65 + 65], 0.01, 1e-6);

    put_lines(at("seen.ndjson"), false, 0.2, 25);               /* then nobody was seen any more */
    check_ok(recording_clips_open(arena, scratch_folder, at("seen.ndjson"), &seen));
    ck_assert_int_eq(seen.n, 1);
    ck_assert_double_eq_tol(seen.body[3], 1.203, 1e-6);
    put_lines(at("seen.ndjson"), false, 1.2, 40);               /* somebody else */
    check_error(recording_clips_open(arena, scratch_folder, at("seen.ndjson"), &seen), LT_EINVAL,
                "of 1 persons none is seen while doing one thing for 15 frames");
    check_error(action_windows(arena, &s, &train, &window, &n), LT_EINVAL, "is scored, and not trained on");
    put_file(at("seen.ndjson"), "{\n", 2);
    check_error(recording_clips_open(arena, scratch_folder, at("seen.ndjson"), &seen), LT_EFORMAT, "seen.ndjson:1");
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, close_scratch);
    tcase_add_test(tc, clips);
    tcase_add_test(tc, nobody_is_seen);
    tcase_add_test(tc, sides);
    tcase_add_test(tc, a_window);
    tcase_add_loop_test(tc, bad_labels, 0, (int)LT_COUNT(bad));
    tcase_add_test(tc, bad_arrays);
    tcase_add_test(tc, cuts);
    tcase_add_test(tc, before_cameras);
}

int main(void)
{
    return run_suite("action", add_tests);
}
