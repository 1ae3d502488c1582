/* SPDX-License-Identifier: Apache-2.0 */
/* `palmar eval --pred` on result files as people hand them in: the truth of the generator's DexYCB and HO3D, written as
 * the toolkits and their users write it, with every slip that they make; called as it should not be. */
#include "assets/hand/hand.h"
#include "data/action/takes.h"
#include "data/dexycb/dexycb.h"
#include "data/mirror.h"
#include "libtensor/geometry/pose.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "tests/suite.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

enum { J = LT_HAND_KEYPOINTS };

#define DEX "field-scores/dex"
#define HO "field-scores/ho"

static lt_arena *arena;
static lt_hand_model *hand;
static char out[1 << 16], said[1 << 16];        /* of the last command: what it printed, and on the error stream */

static void read_back(const char *name, char *text, size_t n)
{
    FILE *f = fopen(in_folder(name), "r");

    ck_assert_ptr_nonnull(f);
    text[fread(text, 1, n - 1, f)] = '\0';
    fclose(f);
}

static int eval(const char *pred, const char *data, const char *more)
{
    const char *command = lt_arena_printf(arena, "./palmar eval --pred %s --data %s %s >%s 2>%s", pred, data, more,
                                          in_folder("out"), in_folder("said"));
    const int rc = system(command);

    read_back("out", out, sizeof(out));
    read_back("said", said, sizeof(said));
    return WEXITSTATUS(rc);
}

static void says(const char *words)
{
    ck_assert_msg(strstr(said, words) != NULL, "\"%s\" lacks \"%s\"", said, words);
}

static void says_nothing_odd(void)
{
    ck_assert_msg(!strstr(said, "looks as if") && !strstr(said, "the first,"), "%s", said);
}

/* ---- DexYCB: the truth as a file ---- */

typedef char *line_writer(char *text, const dexycb_place *p, int object, const lt_pose *pose);

static dataset *open_test(dexycb_filter filter)
{
    dataset *d;

    check_ok(dexycb_open(&(dexycb_options){ .root = DEX, .setup = "s0", .split = "test", .filter = filter,
                                            .hand = hand },
                         &d));
    return d;
}

/* Every object of every key frame; change, if not NULL, changes its pose. */
static const char *put_poses(const char *name, const char *header, line_writer *write, void (*change)(lt_pose *p))
{
    dataset *d = open_test(DEXYCB_EVERY);
    char *text = lt_arena_strdup(arena, header);

    for (int64_t i = 0; i < d->count; i++) {
        const dexycb_place p = dexycb_place_of(d, i);
        dexycb_scene s;
        if (!p.keyframe)
            continue;
        check_ok(dexycb_read_scene(d, i, arena, &s));
        for (int k = 0; k < p.n_targets; k++) {
            lt_pose pose = lt_pose_of(s.pose[k].R, s.pose[k].t);
            if (change)
                change(&pose);
            if (s.pose[k].known)
                text = write(text, &p, p.target[k], &pose);
        }
    }
    dataset_free(d);
    check_ok(lt_write_file(in_folder(name), text, strlen(text)));
    return in_folder(name);
}

static char *line_with(const char *format, char *text, const dexycb_place *p, int object, const lt_pose *e)
{
    char line[1024];

    snprintf(line, sizeof(line), format, p->scene, p->image, object, e->R[0], e->R[1], e->R[2], e->R[3], e->R[4],
             e->R[5], e->R[6], e->R[7], e->R[8], e->t[0], e->t[1], e->t[2]);
    return lt_arena_printf(arena, "%s%s", text, line);
}

#define LINE(name, format) \
    static char *name(char *text, const dexycb_place *p, int object, const lt_pose *e) \
    { return line_with(format, text, p, object, e); }

LINE(plain, "%d,%d,%d,1,%.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g,%.9g %.9g %.9g,-1\n")
LINE(with_blanks, " %d , %d ,%d, 1.0 ,  %.9g  %.9g %.9g\t%.9g %.9g %.9g %.9g %.9g %.9g , %.9g %.9g  %.9g\t, -1 \r\n\n  "
     "\n")
LINE(without_time, "%d,%d,%d,1,%.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g,%.9g %.9g %.9g\n")

static const char header[] = "scene_id,im_id,obj_id,score,R,t,time\n";

/* What BOP's toolkit reads, and a little more. */
static const struct { const char *header; line_writer *line; } readable[] = {
    { header, plain }, { "", plain }, { "", with_blanks }, { header, with_blanks },
    { "\xef\xbb\xbfscene_id,im_id,obj_id,score,R,t,time\r\n", plain }, { "\xef\xbb\xbf", plain },
    { "\n\n", plain }, { "Scene_ID, im_id, obj_id, score, R, t, time\n", plain },
};

START_TEST(poses_are_read)
{
    ck_assert_int_eq(eval(put_poses("poses.csv", readable[_i].header, readable[_i].line, NULL), DEX, ""), 0);
    ck_assert_ptr_nonnull(strstr(out, "1.000000  1.000000  1.000000  1.000000\ngrasp only"));
    says_nothing_odd();
}
END_TEST

static void t_in_mm(lt_pose *p)
{
    for (int i = 0; i < 3; i++)
        p->t[i] *= 1000;
}

static void t_in_cm(lt_pose *p)
{
    for (int i = 0; i < 3; i++)
        p->t[i] *= 100;
}

static void in_opengl(lt_pose *p)
{
    for (int i = 3; i < 9; i++)
        p->R[i] = -p->R[i];
    p->t[1] = -p->t[1];
    p->t[2] = -p->t[2];
}

static void by_columns(lt_pose *p)
{
    const lt_pose old = *p;

    for (int i = 0; i < 9; i++)
        p->R[i] = old.R[3 * (i % 3) + i / 3];
}

static const struct { void (*change)(lt_pose *p); const char *words; } pose_slips[] = {
    { t_in_mm, "poses.csv: it looks as if the translations are in millimetres, not metres\n" },
    { t_in_cm, "poses.csv: it looks as if the translations are in centimetres, not metres\n" },
    { in_opengl, "poses.csv: it looks as if the poses have OpenGL's axes (y up, z backward), not OpenCV's\n" },
    { by_columns, "poses.csv: it looks as if the rotations are written by columns, not by rows\n" },
};

START_TEST(slips_of_poses)
{
    ck_assert_int_eq(eval(put_poses("poses.csv", "", plain, pose_slips[_i].change), DEX, ""), 0);
    says(pose_slips[_i].words);
}
END_TEST

/* One line more than the truth has. */
static const struct { const char *line; int rc; const char *words; } more_lines[] = {
    { "999,0,5,1,1 0 0 0 1 0 0 0 1,0 0 1,-1", 0, "estimates are for nothing that is scored in split test; the first, "
      "line 16: scene 999, and there are 0 to 3\n" },
    { "0,77,5,1,1 0 0 0 1 0 0 0 1,0 0 1,-1", 0, "line 16: scene 0 has no image 77\n" },
    { "0,1,5,1,1 0 0 0 1 0 0 0 1,0 0 1,-1", 0, "line 16: image 1 of scene 0 is no key frame\n" },
    { "0,0,20,1,1 0 0 0 1 0 0 0 1,0 0 1,-1", 0, "line 16: scene 0 has no object 20\n" },
    { "-1,0,5,1,1 0 0 0 1 0 0 0 1,0 0 1,-1", 0, "line 16: scene -1, and there are" },
    { "0,0,5,0.1,1 0 0 0 1 0 0 0 1,nan 0 1,-1", 0, "estimates are no pose and count as misses; the first, line 16: t "
      "is not finite, or farther than 10 km\n" },
    { "0,0,5,0.1,1 0 0 0 1 0 0 0 1,1e154 0 1,-1", 0, "the first, line 16: t is not finite, or farther than 10 km\n" },
    { "0,0,5,0.1,1 0 0 0 1 0 0 0 NaN,0 0 1,-1", 0, "the first, line 16: R has a number that is not finite\n" },
    { "0,0,5,0.1,0 0 0 0 0 0 0 0 0,0 0 1,-1", 0, "the first, line 16: R is no rotation matrix\n" },
    { "0,0,5,0.1,-1 0 0 0 1 0 0 0 1,0 0 1,-1", 0, "the first, line 16: R is no rotation matrix\n" },
    { "0,0,5,nan,1 0 0 0 1 0 0 0 1,0 0 1,-1", 1, "poses.csv:16: expected scene_id,im_id,obj_id,score,R,t,time, with 9 "
      "numbers for R and 3 for t; score is not as it should be\n" },
    { "1e154,0,5,1,1 0 0 0 1 0 0 0 1,0 0 1,-1", 1, "poses.csv:16: expected" },
    { "0,0,5,1,1 0 0 0 1 0 0 0 1 0,0 0 1,-1", 1, "; R is not as it should be\n" },
    { "0,0,5,1,1 0 0 0 1 0 0 0 1,0 1,-1", 1, "; t is not as it should be\n" },
    { "0,0,5,1,1 0 0 0 1 0 0 0 1,0 0 1,-1,3", 1, "; time is not as it should be\n" },
    { "0,x,5,1,1 0 0 0 1 0 0 0 1,0 0 1,-1", 1, "; im_id is not as it should be\n" },
};

START_TEST(odd_lines_of_poses)
{
    const char *path = put_poses("poses.csv", header, plain, NULL);
    FILE *f = fopen(path, "a");

    fprintf(f, "%s\n", more_lines[_i].line);
    fclose(f);
    ck_assert_int_eq(eval(path, DEX, ""), more_lines[_i].rc);
    says(more_lines[_i].words);
    if (!more_lines[_i].rc)                             /* the best estimate of a target counts */
        ck_assert_ptr_nonnull(strstr(out, "1.000000  1.000000  1.000000  1.000000\ngrasp only"));
}
END_TEST

/* ---- DexYCB: hand joints ---- */

static const char *put_hands(const char *name, const char *comma, void (*change)(float (*joints)[3], bool left))
{
    dataset *d = open_test(DEXYCB_VALID);
    char *text = lt_arena_strdup(arena, "");

    for (int64_t i = 0; i < d->count; i++) {
        dataset_sample s;
        bool left;
        check_ok(dataset_annotation(d, i, arena, &s));
        left = s.flags & SAMPLE_MIRRORED;
        for (int j = 0; left && j < J; j++)
            mirror_point(s.joints[j]);
        for (int k = 0; k < 3 * J; k++)
            s.joints[k / 3][k % 3] *= 1000;
        if (change)
            change(s.joints, left);
        text = lt_arena_printf(arena, "%s%lld", text, (long long)dexycb_place_of(d, i).index);
        for (int k = 0; k < 3 * J; k++)
            text = lt_arena_printf(arena, "%s%s%.7g", text, comma, (double)s.joints[k / 3][k % 3]);
        text = lt_arena_printf(arena, "%s\n", text);
    }
    dataset_free(d);
    check_ok(lt_write_file(in_folder(name), text, strlen(text)));
    return in_folder(name);
}

START_TEST(hands_are_read)
{
    static const char *const comma[] = { ",", ", ", " ,\t" };

    ck_assert_int_eq(eval(put_hands("hands.txt", comma[_i], NULL), DEX, ""), 0);
    ck_assert_ptr_eq(strstr(out, "mpjpe_mm: 0.0000"), out);
    says_nothing_odd();
}
END_TEST

static void scale(float (*joints)[3], float by)
{
    for (int k = 0; k < 3 * J; k++)
        joints[k / 3][k % 3] *= by;
}

static void in_metres(float (*joints)[3], bool left)
{
    (void)left;
    scale(joints, 0.001f);
}

static void in_cm(float (*joints)[3], bool left)
{
    (void)left;
    scale(joints, 0.1f);
}

static void from_the_wrist(float (*joints)[3], bool left)
{
    (void)left;
    for (int j = J - 1; j >= 0; j--)
        for (int k = 0; k < 3; k++)
            joints[j][k] -= joints[0][k];
}

static void in_mano_order(float (*joints)[3], bool left)
{
    float old[J][3];

    (void)left;
    memcpy(old, joints, sizeof(old));
    for (int j = 0; j < J; j++)
        memcpy(joints[j], old[lt_simple_to_mano[j]], sizeof(old[0]));
}

static void left_not_mirrored_back(float (*joints)[3], bool left)
{
    for (int j = 0; left && j < J; j++)
        mirror_point(joints[j]);
}

static const struct { void (*change)(float (*joints)[3], bool left); const char *words; } hand_slips[] = {
    { in_metres, "hands.txt: it looks as if the joints are in metres, not millimetres\n" },
    { in_cm, "hands.txt: it looks as if the joints are in centimetres, not millimetres\n" },
    { from_the_wrist,
      "hands.txt: it looks as if the joints are counted from the wrist or the hand's middle, not from" },
    { in_mano_order, "hands.txt: it looks as if the joints are in MANO's order (index, middle, little, ring, thumb; "
      "tips" },
    { left_not_mirrored_back, "hands.txt: left hands: it looks as if the joints have other axes: (-x, y, z) in the "
      "place of" },
};

START_TEST(slips_of_hands)
{
    ck_assert_int_eq(eval(put_hands("hands.txt", ",", hand_slips[_i].change), DEX, ""), 0);
    says(hand_slips[_i].words);
}
END_TEST

/* A joint of the last hand, or a line behind it. */
static float odd_number;

static void odd_joint(float (*joints)[3], bool left)
{
    if (left)
        joints[7][1] = odd_number;
}

START_TEST(odd_lines_of_hands)
{
    const char *path;
    FILE *f;

    odd_number = NAN;
    ck_assert_int_eq(eval(put_hands("hands.txt", ",", odd_joint), DEX, ""), 1);
    says(": joint 7, y is nan, expected millimetres\n");
    odd_number = 1e30f;
    ck_assert_int_eq(eval(put_hands("hands.txt", ",", odd_joint), DEX, ""), 1);
    says(": joint 7, y is 1e+30, expected millimetres\n");
    path = put_hands("hands.txt", ",", NULL);
    f = fopen(path, "a");
    fprintf(f, "99999");
    for (int k = 0; k < 3 * J; k++)
        fprintf(f, ",%d", 100 + k);
    fprintf(f, "\n");
    fclose(f);
    ck_assert_int_eq(eval(path, DEX, ""), 0);
    says("hands.txt: 1 of 17 lines are for no sample of split test; the first, line 17: sample 99999, and there are "
         "16\n");
}
END_TEST

/* ---- what a file is, whatever it is called ---- */

static void copy(const char *from, const char *to)
{
    ck_assert_int_eq(system(lt_arena_printf(arena, "cp %s %s", from, in_folder(to))), 0);
}

START_TEST(called_otherwise)
{
    copy(put_poses("poses.csv", "", plain, NULL), "poses.txt");
    ck_assert_int_eq(eval(in_folder("poses.txt"), DEX, ""), 0);
    ck_assert_ptr_nonnull(strstr(out, "grasp only"));
    copy(put_hands("hands.txt", ",", NULL), "hands.csv");
    ck_assert_int_eq(eval(in_folder("hands.csv"), DEX, ""), 0);
    ck_assert_ptr_nonnull(strstr(out, "relative_mpjpe_mm"));
    copy(in_folder("hands.csv"), "hands");
    ck_assert_int_eq(eval(in_folder("hands"), DEX, ""), 0);
    ck_assert_int_eq(eval(put_poses("cut.csv", "", without_time, NULL), DEX, ""), 1);
    says("cut.csv:1: expected scene_id,im_id,obj_id,score,R,t,time");
    ck_assert_int_eq(eval(in_folder("hands"), HO, ""), 1);
    says("DexYCB's text of hand joints (HPE), and " HO " is a folder of HO3D");
}
END_TEST

static void put_pred(const char *name)
{
    ck_assert_int_eq(system(lt_arena_printf(arena, "{ printf '['; cat %s/evaluation_xyz.json; printf ','; "
                                            "cat %s/evaluation_verts.json; printf ']'; } >%s", HO, HO,
                                            in_folder(name))), 0);
}

START_TEST(ho3d_by_any_name)
{
    static const struct { const char *bytes, *words; } others[] = {
        { "\x1f\x8b\x08 so", "a gzip file, want a result file" }, { "{\"a\": 1}", "a JSON file, want a result file" },
        { "hello\n", "not a result file" }, { "", "an empty file, want a result file" },
        { "[{\"image_id\": 0, \"category_id\": 22}]", "COCO's JSON of detections, which is not scored" },
        { "\x80\x02}q\x01.", "a pickle of Python, want a result file" },
    };

    put_pred("pred.csv");
    ck_assert_int_eq(eval(in_folder("pred.csv"), HO, ""), 0);
    ck_assert_ptr_eq(strstr(out, "xyz_mean3d: 0.000000\n"), out);
    ck_assert_int_eq(eval(in_folder("pred.csv"), DEX, ""), 1);
    says("HO3D's pred.json, and " DEX " is a folder of DexYCB");
    copy(HO "/evaluation_xyz.json", "joints.json");
    ck_assert_int_eq(eval(in_folder("joints.json"), HO, ""), 0);
    says("joints.json: has joints alone, so that the mesh scores are -1");
    ck_assert_ptr_nonnull(strstr(out, "\nmesh_mean3d: -100.000000\nmesh_auc3d: -1.000000\n"));
    for (size_t i = 0; i < LT_COUNT(others); i++) {
        check_ok(lt_write_file(in_folder("other"), others[i].bytes, strlen(others[i].bytes)));
        ck_assert_int_eq(eval(in_folder("other"), i % 2 ? HO : DEX, ""), 1);
        says(others[i].words);
    }
}
END_TEST

/* ---- some subjects alone ---- */

START_TEST(subject_1_alone)
{
    ck_assert_int_eq(system(lt_arena_printf(arena, "cp -r %s %s && rm -r %s/*-subject-0[23]", DEX, in_folder("part"),
                                            in_folder("part"))), 0);
    ck_assert_int_eq(system(lt_arena_printf(arena, "./palmar info --data %s --json >%s 2>%s", in_folder("part"),
                                            in_folder("out"), in_folder("said"))), 0);
    read_back("out", out, sizeof(out));
    ck_assert_ptr_nonnull(strstr(out, "\"subjects\": {\"20260101-subject-01\": 10}"));
    ck_assert_ptr_nonnull(strstr(out, "{\"code\": \"partial\", \"text\": \"train: split train of s0 is of subject 1 "
                                      "alone: there is no folder of 2, 3;"));
    ck_assert_ptr_nonnull(strstr(out, "{\"code\": \"empty-split\", \"text\": \"test: no subject of this split of s0 is "
                                 "there"));
    ck_assert_int_eq(eval(put_hands("hands.txt", ",", NULL), in_folder("part"), "--split val"), 0);
    says("part: split val of s0 is of subject 1 alone: there is no folder of 2; what is scored is a part of the split");
    ck_assert_int_eq(eval(in_folder("hands.txt"), in_folder("part"), ""), 1);
    says("split test of s0 is of subjects 3, and no folder like ########-subject-03 is there");
}
END_TEST

/* ---- takes as clips of actions ---- */

static const float *points_at(const action_set *s, int64_t clip, int frame)
{
    return s->hand_object + (clip * 3 * s->length + frame) * ACTION_HAND_OBJECT;
}

/* Four clips of each take in which something is grasped; placing is picking up backwards. */
START_TEST(takes_become_clips)
{
    action_set s;

    ck_assert(action_is_takes(DEX) && !action_is_takes(HO));
    check_ok(action_open_takes(arena, DEX, hand, &s));
    ck_assert(s.no_body && s.synthetic && s.n >= 4 && s.n % 4 == 0);
    for (int64_t i = 0; i < s.n; i += 4) {
        const action_clip *c = &s.clip[i];

        ck_assert(c[0].cls == 2 && c[1].cls == 9 && c[2].cls == 8 && c[3].cls == 7);
        ck_assert_int_eq(c[1].frames, c[3].frames);
        for (int k = 0; k < c[1].frames; k++) {
            const int back = c[3].frames - 1 - k;

            ck_assert_int_eq(s.valid[(i + 1) * s.length + k], s.valid[(i + 3) * s.length + back]);
            ck_assert_mem_eq(points_at(&s, i + 1, k), points_at(&s, i + 3, back), ACTION_HAND_OBJECT * sizeof(float));
        }
    }
}
END_TEST

static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
    ck_assert_int_eq(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand), LT_OK);
}

static void teardown(void)
{
    remove_scratch_folder();
    lt_arena_free(arena);
}

static void make_data(void)
{
    ck_assert_int_eq(system("rm -rf field-scores && ./palmar synth --preset tiny --frames 12 --out " HO
                            " >/dev/null 2>&1 && "
                            "./palmar synth --preset tiny --layout dexycb --out " DEX " >/dev/null 2>&1"), 0);
}

static void remove_data(void)
{
    ck_assert_int_eq(system("rm -r field-scores"), 0);
}

static void add_tests(TCase *c)
{
    tcase_set_timeout(c, 0);
    tcase_add_unchecked_fixture(c, make_data, remove_data);
    tcase_add_checked_fixture(c, setup, teardown);
    tcase_add_loop_test(c, poses_are_read, 0, LT_COUNT(readable));
    tcase_add_loop_test(c, slips_of_poses, 0, LT_COUNT(pose_slips));
    tcase_add_loop_test(c, odd_lines_of_poses, 0, LT_COUNT(more_lines));
    tcase_add_loop_test(c, hands_are_read, 0, 3);
    tcase_add_loop_test(c, slips_of_hands, 0, LT_COUNT(hand_slips));
    tcase_add_test(c, odd_lines_of_hands);
    tcase_add_test(c, called_otherwise);
    tcase_add_test(c, ho3d_by_any_name);
    tcase_add_test(c, subject_1_alone);
    tcase_add_test(c, takes_become_clips);
}

int main(void)
{
    return run_suite("scores", add_tests);
}
