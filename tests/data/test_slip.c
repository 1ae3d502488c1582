/* SPDX-License-Identifier: Apache-2.0 */
/* Slips in hands that are made up here: each is named, alone and with others, under an estimator's errors and beside
 * samples that are worth nothing; and where there is none, nothing is said. */
#include "assets/hand/hand.h"
#include "data/slip.h"
#include "libtensor/base/rng.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

#include <math.h>

enum { N = 60, J = LT_HAND_KEYPOINTS };

static lt_arena *arena;
static lt_hand_model *hand;
static float truth[N][J][3], found[N][J][3];
static double spread;               /* metres of an estimator's error */

static void pose_hands(void)
{
    lt_rng rng = lt_rng_make(8, 1);
    double (*v)[3] = lt_arena_array(arena, LT_HAND_VERTICES, sizeof(*v));

    for (int i = 0; i < N; i++) {
        double R[16 * 9], beta[10] = { 0 }, aa[3], at[3] = { 0 }, j[16][3], key[J][3];
        for (int k = 0; k < 16; k++) {
            for (int a = 0; a < 3; a++)
                aa[a] = lt_rng_range(&rng, -1, 1) * (k ? 0.3 : 2);
            lt_rot_from_axis_angle(aa, R + 9 * k);
        }
        for (int a = 0; a < 3; a++)
            at[a] = a < 2 ? lt_rng_range(&rng, -0.15, 0.15) : lt_rng_range(&rng, 0.4, 0.9);
        lt_hand_pose(hand, R, beta, at, v[0], j[0]);
        lt_hand_keypoints(v[0], j[0], lt_hand_tips_ho3d, LT_HAND_SIMPLE_ORDER, key[0]);
        for (int p = 0; p < J; p++)
            for (int a = 0; a < 3; a++)
                truth[i][p][a] = (float)key[p][a];
    }
}

static void estimate(double error)
{
    lt_rng rng = lt_rng_make(9, 2);

    spread = error;
    for (int i = 0; i < N; i++) {
        double away[3];
        for (int a = 0; a < 3; a++)
            away[a] = 2 * error * lt_rng_normal(&rng);
        for (int p = 0; p < J; p++)
            for (int a = 0; a < 3; a++)
                found[i][p][a] = (float)(truth[i][p][a] + away[a] + error * lt_rng_normal(&rng) / sqrt(3));
    }
}

/* ---- slips ---- */

static void scale(double by)
{
    for (int i = 0; i < N * J * 3; i++)
        found[i / 3 / J][i / 3 % J][i % 3] *= (float)by;
}

static void millimetres(void) { scale(1000); }
static void centimetres(void) { scale(100); }
static void twice_divided(void) { scale(0.001); }
static void three_times(void) { scale(3); }

static void axes(const int from[3], const int sign[3])
{
    for (int i = 0; i < N; i++)
        for (int p = 0; p < J; p++) {
            const float x[3] = { found[i][p][0], found[i][p][1], found[i][p][2] };
            for (int a = 0; a < 3; a++)
                found[i][p][a] = (float)sign[a] * x[from[a]];
        }
}

static const int plain[3] = { 0, 1, 2 };

static void other_graphics(void) { axes(plain, (const int[]){ 1, -1, -1 }); }
static void mirrored(void) { axes(plain, (const int[]){ -1, 1, 1 }); }
static void exchanged(void) { axes((const int[]){ 1, 0, 2 }, (const int[]){ 1, 1, 1 }); }
static void z_up(void) { axes((const int[]){ 0, 2, 1 }, (const int[]){ 1, 1, -1 }); }

static void order(const int *from)
{
    for (int i = 0; i < N; i++) {
        float old[J][3];
        memcpy(old, found[i], sizeof(old));
        for (int p = 0; p < J; p++)
            memcpy(found[i][p], old[from[p]], sizeof(old[0]));
    }
}

static const int interhand[J] = { 4, 3, 2, 1, 8, 7, 6, 5, 12, 11, 10, 9, 16, 15, 14, 13, 20, 19, 18, 17, 0 };
static const int rhd[J] = { 0, 4, 3, 2, 1, 8, 7, 6, 5, 12, 11, 10, 9, 16, 15, 14, 13, 20, 19, 18, 17 };
static const int fphab[J] = { 0, 1, 5, 9, 13, 17, 2, 3, 4, 6, 7, 8, 10, 11, 12, 14, 15, 16, 18, 19, 20 };
static const int from_little[J] = { 0, 17, 18, 19, 20, 13, 14, 15, 16, 9, 10, 11, 12, 5, 6, 7, 8, 1, 2, 3, 4 };

static void mano(void) { order(lt_simple_to_mano); }                /* joint k of the file: MANO's k */
static void simple_read_as_mano(void) { order(lt_mano_to_simple); }
static void as_interhand(void) { order(interhand); }
static void as_rhd(void) { order(rhd); }
static void as_fphab(void) { order(fphab); }
static void little_first(void) { order(from_little); }
static void interhand_read_as_mano(void) { order(interhand), order(lt_mano_to_simple); }

static void from_wrist(void)
{
    for (int i = 0; i < N; i++)
        for (int p = J - 1; p >= 0; p--)
            for (int a = 0; a < 3; a++)
                found[i][p][a] -= found[i][0][a];
}

/* The hand is right; the wrist was turned, or scaled, alone. */
static void wrists(double by, const int sign[3])
{
    for (int i = 0; i < N; i++)
        for (int a = 0; a < 3; a++) {
            const double w = found[i][0][a], moved = by * sign[a] * w;
            for (int p = 0; p < J; p++)
                found[i][p][a] += (float)(moved - w);
        }
}

static void wrists_in_opengl(void) { wrists(1, (const int[]){ 1, -1, -1 }); }
static void wrists_in_mm(void) { wrists(1000, (const int[]){ 1, 1, 1 }); }

static void mm_and_opengl(void) { millimetres(), other_graphics(); }
static void all_three(void) { millimetres(), other_graphics(), mano(); }
static void mm_from_wrist(void) { from_wrist(), millimetres(); }

/* Three frames of sixty are far out, as diverged optimisers leave them; they say nothing of the others. */
static void some_are_lost(void)
{
    for (int i = 5; i < N; i += 20)
        for (int p = 0; p < J; p++)
            found[i][p][1] *= 4e4f;
}

static void mm_and_some_lost(void) { millimetres(), some_are_lost(); }

static void some_are_nan(void)
{
    millimetres();
    for (int i = 1; i < N; i += 7)
        found[i][i % J][2] = NAN;
}

static const struct { void (*make)(void); const char *code, *words; } cases[] = {
    { millimetres, "unit", "are in millimetres, not metres" },
    { centimetres, "unit", "are in centimetres, not metres" },
    { twice_divided, "unit", "are 1000 times too small" },
    { other_graphics, "axes", "have OpenGL's axes (y up, z backward), not OpenCV's" },
    { mirrored, "axes", "have other axes: (-x, y, z) in the place of (x, y, z) would fit" },
    { exchanged, "axes", "(y, x, z) in" }, { z_up, "axes", "(x, -z, y) in" },
    { mano, "order", "are in MANO's order" },
    { simple_read_as_mano, "order", "are ordered from thumb to little finger" },
    { as_interhand, "order", "as InterHand has them" }, { interhand_read_as_mano, "order", "as InterHand has them" },
    { as_rhd, "order", "as RHD has them" }, { as_fphab, "order", "as F-PHAB and HANDS" },
    { little_first, "order", "are ordered from little finger to thumb" },
    { from_wrist, "place", "are counted from the wrist" },
    { wrists_in_opengl, "place", "are placed in OpenGL's axes" },
    { wrists_in_mm, "place", "are placed 1000 times as far away" },
    { mm_and_opengl, "unit",
      "are in millimetres, not metres, and have OpenGL's axes (y up, z backward), not OpenCV's" },
    { all_three, "unit", "not OpenCV's, and are in MANO's order" },
    { mm_from_wrist, "unit", "are in millimetres, not metres, and are counted from the wrist" },
    { mm_and_some_lost, "unit", "are in millimetres" }, { some_are_nan, "unit", "are in millimetres" },
    { three_times, "size", "are those of hands of 3" },
};

static slip look(slip_file file)
{
    const slip_points p = { .what = "the joints", .file = file, .n = N, .points = J, .found = found[0][0],
                            .wanted = truth[0][0], .skip = -1, .places = true };
    slip s;

    slip_in_points(&p, &s);
    return s;
}

static void expect(slip s, const char *code, const char *words)
{
    ck_assert_msg(s.code != NULL, "nothing is said, want \"%s\"", words);
    ck_assert_msg(strstr(s.text, words) != NULL, "\"%s\" lacks \"%s\"", s.text, words);
    ck_assert_str_eq(s.code, strcmp(code, "place") || strncmp(s.text, "the joints are placed in", 24) ? code : "axes");
    ck_assert_ptr_eq(strstr(s.text, "the joints "), s.text);
}

START_TEST(named)
{
    slip s;

    estimate(0);
    cases[_i].make();
    s = look((slip_file){ 0 });
    expect(s, cases[_i].code, cases[_i].words);
    if (strcmp(cases[_i].code, "size") && strcmp(cases[_i].code, "place"))
        ck_assert_double_lt(s.after, 1e-4);
}
END_TEST

/* Two centimetres of error a joint, four of place: what networks do. */
START_TEST(named_under_errors)
{
    estimate(0.015);
    cases[_i].make();
    expect(look((slip_file){ 0 }), cases[_i].code, cases[_i].words);
}
END_TEST

/* In the words of a file with OpenGL's axes, or in millimetres. */
START_TEST(in_the_files_words)
{
    estimate(0.01);
    other_graphics();
    expect(look((slip_file){ .opengl = true }), "axes", "have OpenCV's axes (y down, z forward), not OpenGL's");
    estimate(0.01);
    mirrored();
    expect(look((slip_file){ .opengl = true }), "axes", "(-x, y, z) in the place of");
    estimate(0.01);
    exchanged();                                    /* their y is up */
    expect(look((slip_file){ .opengl = true }), "axes", "(-y, -x, z) in the place of");
    estimate(0.01);
    twice_divided();
    expect(look((slip_file){ .millimetres = true }), "unit", "are in metres, not millimetres");
    estimate(0.01);
    scale(0.1);
    expect(look((slip_file){ .millimetres = true }), "unit", "are in centimetres, not millimetres");
    estimate(0.01);
    scale(1000);
    expect(look((slip_file){ .millimetres = true }), "unit", "are 1000 times too large");
}
END_TEST

static void nothing_said(const char *of)
{
    const slip s = look((slip_file){ 0 });

    ck_assert_msg(!s.code && !*s.text, "%s: \"%s\"", of, s.text);
}

/* Estimators that are good, bad, or look at nothing have made no slip. */
START_TEST(nothing_to_say)
{
    estimate(0);
    nothing_said("the truth");
    estimate(0.01);
    nothing_said("a good one");
    some_are_lost();
    nothing_said("a good one that diverges at times");
    estimate(0.04);
    nothing_said("a bad one");
    memset(found, 0, sizeof(found));
    nothing_said("zero");
    for (int i = 0; i < N; i++)
        for (int p = 0; p < J; p++)
            for (int a = 0; a < 3; a++)
                found[i][p][a] = truth[0][p][a] - truth[0][0][a] + truth[i][0][a];
    nothing_said("one pose for all");
    for (int i = 0; i < N; i++)
        memcpy(found[i], truth[(i + 17) % N], sizeof(found[i]));
    nothing_said("the hands of other frames");
    for (int i = 0; i < N * J * 3; i++)
        found[i / 3 / J][i / 3 % J][i % 3] = NAN;
    nothing_said("no numbers");
}
END_TEST

/* Any number of points has units, axes and places, but no order. */
START_TEST(meshes)
{
    const slip_points p = { .what = "the vertices", .n = N * J / 63, .points = 63, .found = found[0][0],
                            .wanted = truth[0][0], .skip = -1, .places = true };
    slip s;

    estimate(0.003);
    mm_and_opengl();
    slip_in_points(&p, &s);
    ck_assert_str_eq(s.text, "the vertices are in millimetres, not metres, and have OpenGL's axes (y up, z backward), "
                     "not OpenCV's");
}
END_TEST

/* ---- poses ---- */

static slip_pose poses[N];

static void pose_objects(void)
{
    lt_rng rng = lt_rng_make(8, 3);

    for (int i = 0; i < N; i++) {
        slip_pose *p = &poses[i];
        const double aa[3] = { lt_rng_range(&rng, -2, 2), lt_rng_range(&rng, -2, 2), lt_rng_range(&rng, -2, 2) };
        *p = (slip_pose){ .centre = { 0.01, -0.012, 0.025 } };
        lt_rot_from_axis_angle(aa, p->wanted.R);
        for (int a = 0; a < 3; a++)
            p->wanted.t[a] = a < 2 ? lt_rng_range(&rng, -0.15, 0.15) : lt_rng_range(&rng, 0.4, 0.9);
        for (int c = 0; c < 8; c++)
            for (int a = 0; a < 3; a++)
                p->corner[c][a] = p->centre[a] + (c >> a & 1 ? 0.05 : -0.05) * (a + 1);
        p->found = p->wanted;
    }
}

static void t_in_mm(lt_pose *p)
{
    for (int a = 0; a < 3; a++)
        p->t[a] *= 1000;
}

static void transposed(lt_pose *p)
{
    const lt_pose old = *p;

    lt_mat3_transpose(old.R, p->R);
}

static void in_graphics(lt_pose *p)
{
    for (int i = 3; i < 9; i++)
        p->R[i] = -p->R[i];
    p->t[1] = -p->t[1];
    p->t[2] = -p->t[2];
}

static void mm_and_graphics(lt_pose *p) { t_in_mm(p), in_graphics(p); }

static void inverse(lt_pose *p)
{
    const lt_pose old = *p;
    double t[3];

    transposed(p);
    lt_mat3_mulvec(p->R, old.t, t);
    for (int a = 0; a < 3; a++)
        p->t[a] = -t[a];
}

static void centred(lt_pose *p)
{
    double c[3];

    lt_mat3_mulvec(p->R, poses[0].centre, c);
    for (int a = 0; a < 3; a++)
        p->t[a] += c[a];
}

static void right(lt_pose *p) { (void)p; }

static const struct { void (*make)(lt_pose *p); const char *code, *words; } pose_cases[] = {
    { right, NULL, "" }, { t_in_mm, "unit", "the translations are in millimetres, not metres" },
    { transposed, "axes", "the rotations are written by columns, not by rows" },
    { in_graphics, "axes", "the poses have OpenGL's axes (y up, z backward), not OpenCV's" },
    { mm_and_graphics, "unit", "the translations are in millimetres, not metres, and the poses have OpenGL's axes (y "
      "up, z backward), not OpenCV's" },
    { inverse, "place", "the poses are the camera's in the object's frame, not the object's in the camera's" },
    { centred, "place", "the poses are of BOP's models, whose origin is the middle of their box" },
};

/* A fifth of the estimates are of something else; the rest are a few millimetres off. */
START_TEST(poses_named)
{
    lt_rng rng = lt_rng_make(8, 5);
    slip s;

    pose_objects();
    for (int i = 0; i < N; i++) {
        for (int a = 0; a < 3; a++)
            poses[i].found.t[a] += i % 5 ? 0.002 * lt_rng_normal(&rng) : lt_rng_range(&rng, -1, 1);
        pose_cases[_i].make(&poses[i].found);
    }
    slip_in_poses(poses, N, (slip_file){ 0 }, &s);
    ck_assert_str_eq(s.text, pose_cases[_i].words);
    ck_assert(!s.code == !pose_cases[_i].code && (!s.code || !strcmp(s.code, pose_cases[_i].code)));
}
END_TEST

/* ---- intrinsics, sizes ---- */

static const struct { lt_camera c; const char *words; } cameras[] = {
    { { 614, 613, 320, 240 }, "" }, { { 600, 600, 310, 262 }, "" }, { { 500, 500, 350, 220 }, "" },
    { { 1840, 1840, 960, 720 }, "the intrinsics are those of an image of 1920 x 1440, not of 640 x 480" },
    { { 307, 307, 160, 120 }, "the intrinsics are those of an image of 320 x 240, not of 640 x 480" },
    { { 614, 613, 240, 320 }, "cx and cy are exchanged" },
    { { 0.95, 1.27, 0.5, 0.5 }, "the intrinsics are in units of the image's sides, not in pixels" },
    { { 4.2, 4.2, 320, 240 }, "the focal length, 4.2, is in millimetres, not in pixels" },
    { { 614000, 613000, 320, 240 }, "the focal length is 6.14e+05, 6.13e+05 pixels" },
    { { 606, 606, 316, 5000 }, "the intrinsics are those of another image: their principal point (316, 5000) is far "
      "from the middle of 640 x 480" },
};

START_TEST(cameras_named)
{
    slip s;

    slip_in_camera(&cameras[_i].c, 640, 480, &s);
    ck_assert_str_eq(s.text, cameras[_i].words);
    ck_assert_int_eq(s.code != NULL, *cameras[_i].words != 0);
}
END_TEST

START_TEST(units_of_sizes)
{
    ck_assert_int_eq(slip_unit(0.191, 0.02, 1), 0);
    ck_assert_int_eq(slip_unit(191, 0.02, 1), -3);
    ck_assert_int_eq(slip_unit(19.1, 0.02, 1), -2);
    ck_assert_int_eq(slip_unit(0.000191, 0.02, 1), 3);
    ck_assert_int_eq(slip_unit(0, 0.02, 1), 0);
    ck_assert_int_eq(slip_unit(NAN, 0.02, 1), 0);
    ck_assert_int_eq(slip_unit(1e30, 0.02, 1), 0);
}
END_TEST

static void setup(void)
{
    arena = lt_arena_new();
    ck_assert_int_eq(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand), LT_OK);
    pose_hands();
}

static void teardown(void)
{
    lt_arena_free(arena);
}

static void add_tests(TCase *c)
{
    tcase_set_timeout(c, 0);
    tcase_add_unchecked_fixture(c, setup, teardown);
    tcase_add_loop_test(c, named, 0, LT_COUNT(cases));
    tcase_add_loop_test(c, named_under_errors, 0, LT_COUNT(cases));
    tcase_add_test(c, in_the_files_words);
    tcase_add_test(c, nothing_to_say);
    tcase_add_test(c, meshes);
    tcase_add_loop_test(c, poses_named, 0, LT_COUNT(pose_cases));
    tcase_add_loop_test(c, cameras_named, 0, LT_COUNT(cameras));
    tcase_add_test(c, units_of_sizes);
}

int main(void)
{
    return run_suite("slip", add_tests);
}
