/* SPDX-License-Identifier: Apache-2.0 */
/* A dataset's self-test on datasets made up here: each slip is named, missing and bad samples are counted. */
#include "assets/hand/hand.h"
#include "data/check.h"
#include "data/mirror.h"
#include "libtensor/geometry/hand/layer.h"
#include "libtensor/geometry/rotation.h"
#include "tests/suite.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { COUNT = 3000 };

static lt_arena *arena;
static lt_hand_model *hand;

/* ---- a dataset whose hands are wrong in one way ---- */

typedef struct {
    dataset base;
    void (*spoil)(dataset_sample *s);
    bool left;
} fake;

static void angles_of(const dataset_sample *s, double pose[45])
{
    for (int j = 1; j < 16; j++) {
        double R[9];
        for (int i = 0; i < 9; i++)
            R[i] = s->rotation[j][i];
        lt_rot_to_axis_angle(R, pose + 3 * (j - 1));
    }
}

static void set_angles(dataset_sample *s, const double pose[45])
{
    for (int j = 1; j < 16; j++) {
        double R[9];
        lt_rot_from_axis_angle(pose + 3 * (j - 1), R);
        for (int i = 0; i < 9; i++)
            s->rotation[j][i] = (float)R[i];
    }
}

static lt_status annotation(const dataset *d, int64_t index, lt_arena *scratch, dataset_sample *out)
{
    const fake *f = (const fake *)d;
    lt_rng rng = lt_rng_make(4, (uint64_t)index);
    double R[16 * 9], beta[10], v[LT_HAND_VERTICES][3], j[16][3], key[21][3], pose[45];

    (void)scratch;
    if (index % 1000 == 7)
        return lt_error(LT_EFORMAT, "sample %d: is bad", (int)index);
    *out = (dataset_sample){ .flags = SAMPLE_HAND_POSE | SAMPLE_JOINTS | SAMPLE_ROOT, .width = 640, .height = 480,
                             .camera = { 600, 600, 320, 240 } };
    for (int i = 0; i < 45; i++)
        pose[i] = hand->hands_mean[i] + lt_rng_range(&rng, -0.3, 0.3);
    set_angles(out, pose);
    lt_rot_from_axis_angle((const double[]){ 0.4, -0.8, 1.2 }, R);
    for (int i = 0; i < 9; i++)
        out->rotation[0][i] = (float)R[i];
    for (int i = 0; i < 10; i++)
        beta[i] = out->beta[i] = (float)lt_rng_range(&rng, -1.5, 1.5);
    for (int i = 0; i < 16 * 9; i++)
        R[i] = out->rotation[i / 9][i % 9];
    lt_hand_pose(hand, R, beta, (const double[]){ 0, 0, 0.6 }, v[0], j[0]);
    lt_hand_keypoints(v[0], j[0], lt_hand_tips_ho3d, LT_HAND_SIMPLE_ORDER, key[0]);
    for (int i = 0; i < 63; i++)
        out->joints[i / 3][i % 3] = (float)key[i / 3][i % 3];
    if (f->left)
        out->flags |= SAMPLE_MIRRORED;
    f->spoil(out);
    return LT_OK;
}

static lt_status read_sample(const dataset *d, int64_t index, unsigned want, lt_arena *scratch, dataset_sample *out)
{
    (void)want;
    return annotation(d, index, scratch, out);
}

static const char *missing(const dataset *d, int64_t index, lt_arena *scratch)
{
    (void)d;
    return index == 1500 || index > 2997 ? lt_arena_printf(scratch, "file %d", (int)index) : NULL;
}

static const dataset_ops ops = { read_sample, annotation, missing, NULL, NULL };

static fake make(void (*spoil)(dataset_sample *s), bool left)
{
    return (fake){ .base = { .ops = &ops, .root = "made up", .count = COUNT, .tips = lt_hand_tips_ho3d }, spoil, left };
}

/* ---- slips ---- */

static void nothing(dataset_sample *s) { (void)s; }

static void permuted(dataset_sample *s, const int *from)
{
    float old[21][3];

    memcpy(old, s->joints, sizeof(old));
    for (int i = 0; i < 21; i++)
        memcpy(s->joints[i], old[from[i]], sizeof(old[0]));
}

static void in_mano_order(dataset_sample *s) { permuted(s, lt_simple_to_mano); }
static void reordered_twice(dataset_sample *s) { permuted(s, lt_mano_to_simple); }

static void tips_first(dataset_sample *s)
{
    static const int from[21] = { 4, 3, 2, 1, 8, 7, 6, 5, 12, 11, 10, 9, 16, 15, 14, 13, 20, 19, 18, 17, 0 };

    permuted(s, from);
}

static void in_opengl(dataset_sample *s)
{
    for (int i = 0; i < 21; i++)
        for (int k = 1; k < 3; k++)
            s->joints[i][k] = -s->joints[i][k];
}

static void in_mm(dataset_sample *s)
{
    for (int i = 0; i < 63; i++)
        s->joints[i / 3][i % 3] *= 1000;
}

static void coefficients_as_angles(dataset_sample *s)
{
    double pose[45], c[45];

    angles_of(s, pose);
    for (int k = 0; k < 45; k++) {
        c[k] = 0;
        for (int i = 0; i < 45; i++)
            c[k] += (pose[i] - hand->hands_mean[i]) * hand->hands_components[k][i];
    }
    set_angles(s, c);
}

static void angles_as_coefficients(dataset_sample *s)
{
    double pose[45], x[45];

    angles_of(s, pose);
    for (int i = 0; i < 45; i++) {
        x[i] = hand->hands_mean[i];
        for (int k = 0; k < 45; k++)
            x[i] += pose[k] * hand->hands_components[k][i];
    }
    set_angles(s, x);
}

static void shifted(dataset_sample *s, double sign)
{
    double pose[45];

    angles_of(s, pose);
    for (int i = 0; i < 45; i++)
        pose[i] += sign * hand->hands_mean[i];
    set_angles(s, pose);
}

static void no_mean(dataset_sample *s) { shifted(s, -1); }
static void mean_twice(dataset_sample *s) { shifted(s, 1); }

/* Made with a hand whose shape directions have the other sign in x. */
static void other_sign(dataset_sample *s)
{
    static lt_hand_model turned;
    double R[16 * 9], beta[10], v[LT_HAND_VERTICES][3], j[16][3], key[21][3];

    turned = *hand;
    for (int i = 0; i < LT_HAND_VERTICES; i++)
        for (int b = 0; b < 10; b++)
            turned.shapedirs[i][0][b] = -turned.shapedirs[i][0][b];
    for (int i = 0; i < 16 * 9; i++)
        R[i] = s->rotation[i / 9][i % 9];
    for (int i = 0; i < 10; i++)
        beta[i] = s->beta[i];
    lt_hand_pose(&turned, R, beta, (const double[]){ 0, 0, 0.6 }, v[0], j[0]);
    lt_hand_keypoints(v[0], j[0], lt_hand_tips_ho3d, LT_HAND_SIMPLE_ORDER, key[0]);
    for (int i = 0; i < 63; i++)
        s->joints[i / 3][i % 3] = (float)key[i / 3][i % 3];
}

/* Everything of the hand turned to OpenGL's axes: the pose agrees with itself, but nothing is in view. */
static void behind_the_camera(dataset_sample *s)
{
    in_opengl(s);
    for (int i = 3; i < 9; i++)
        s->rotation[0][i] = -s->rotation[0][i];
}

static void another_hand(dataset_sample *s)
{
    for (int i = 0; i < 63; i++)
        s->joints[i / 3][i % 3] *= 1.1f;
}

static const struct { void (*spoil)(dataset_sample *s); bool left; const char *name; } cases[] = {
    { in_mano_order, false, "MANO's order" }, { reordered_twice, false, "thumb to little finger" },
    { tips_first, false, "from the tips down" }, { in_opengl, false, "OpenGL's axes" }, { in_mm, false, "millimetres" },
    { coefficients_as_angles, false, "made of PCA coefficients" }, { angles_as_coefficients, false, "made of angles" },
    { no_mean, false, "lacks the mean pose" }, { mean_twice, false, "has the mean pose in it" },
    { other_sign, true, "shapedirs" }, { behind_the_camera, false, "not where the camera looks" },
};

START_TEST(names_the_slip)
{
    const fake f = make(cases[_i].spoil, cases[_i].left);
    check_hands c;

    ck_assert_int_eq(check_pose(&f.base, hand, 20, cases[_i].left, &c), LT_OK);
    ck_assert_int_eq(c.hands, 20);
    ck_assert(!check_hands_good(&c));
    ck_assert_ptr_nonnull(c.slip.code);
    ck_assert_msg(strstr(c.slip.text, cases[_i].name), "\"%s\" lacks \"%s\"", c.slip.text, cases[_i].name);
}
END_TEST

START_TEST(nothing_is_wrong)
{
    const fake f = make(nothing, false);
    check_hands c;

    ck_assert_int_eq(check_pose(&f.base, hand, 20, false, &c), LT_OK);
    ck_assert(check_hands_good(&c));
    ck_assert_double_lt(c.rms_mm, 1e-3);
    ck_assert_double_eq(c.in_view, 1);
    ck_assert_ptr_null(c.slip.code);
    ck_assert_int_eq(check_pose(&f.base, hand, 20, true, &c), LT_OK);       /* no left hand is there */
    ck_assert_int_eq(c.hands, 0);
    ck_assert(check_hands_good(&c));
}
END_TEST

/* What no slip explains is said to be wrong, without an explanation. */
START_TEST(says_when_it_does_not_know)
{
    const fake f = make(another_hand, false);
    check_hands c;

    ck_assert_int_eq(check_pose(&f.base, hand, 20, false, &c), LT_OK);
    ck_assert(!check_hands_good(&c));
    ck_assert_ptr_null(c.slip.code);
}
END_TEST

START_TEST(counts_files_and_samples)
{
    const fake f = make(nothing, false);
    check_missing m;
    check_samples s;

    ck_assert_int_eq(check_files(&f.base, arena, &m), LT_OK);
    ck_assert_int_eq(m.samples, 3);
    ck_assert_str_eq(m.first, "file 1500");
    ck_assert_int_eq(check_read(&f.base, 0, arena, &s), LT_OK);
    ck_assert_int_eq(s.read, COUNT);
    ck_assert_int_eq(s.bad, 3);
    ck_assert_int_eq(s.n_lines, 3);
    ck_assert_str_eq(s.line[1], "sample 1007: is bad");
    ck_assert_int_eq(check_read(&f.base, 30, arena, &s), LT_OK);            /* every hundredth */
    ck_assert_int_eq(s.read, 30);
    ck_assert_int_eq(s.bad, 0);
}
END_TEST

static void setup(void)
{
    arena = lt_arena_new();
    ck_assert_int_eq(synth_hand_new(arena, SYNTH_HAND_MANO_LIKE, &hand), LT_OK);
}

static void teardown(void)
{
    lt_arena_free(arena);
}

static void add_tests(TCase *c)
{
    tcase_add_unchecked_fixture(c, setup, teardown);
    tcase_set_timeout(c, 0);
    tcase_add_loop_test(c, names_the_slip, 0, LT_COUNT(cases));
    tcase_add_test(c, nothing_is_wrong);
    tcase_add_test(c, says_when_it_does_not_know);
    tcase_add_test(c, counts_files_and_samples);
}

int main(void)
{
    setenv("CK_FORK", "no", 1);         /* the threads that parallel loops leave do not survive a fork */
    return run_suite("check", add_tests);
}
