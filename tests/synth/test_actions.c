/* SPDX-License-Identifier: Apache-2.0 */
/* Clips of actions: what programs make of a skeleton, what a difficulty adds, and the files. */
#include "data/action/action.h"
#include "libtensor/base/parallel.h"
#include "libtensor/io/file.h"
#include "synth/actions/actions.h"
#include "synth/actions/clip.h"
#include "synth/actions/program.h"
#include "tests/suite.h"

#include <math.h>

enum { SEED = 5, REACHING = 2, RECEIVING = 6, PICKING = 9 };

static float body[3 * CLIP_FRAMES * ACTION_BODY], hand_object[3 * CLIP_FRAMES * ACTION_HAND_OBJECT];
static uint8_t valid[CLIP_FRAMES];

static clip make(int cls, double difficulty)
{
    clip c = { .body = body, .hand_object = hand_object, .valid = valid };

    memset(body, 0, sizeof(body));
    memset(hand_object, 0, sizeof(hand_object));
    memset(valid, 0, sizeof(valid));
    clip_make(SEED, difficulty, &(clip_number){ 1, cls, 3 }, &c);
    return c;
}

static double between(int k, int a, int b)
{
    double sum = 0;

    for (int c = 0; c < 3; c++) {
        const double d = (double)body[(c * CLIP_FRAMES + k) * ACTION_BODY + a]
            - (double)body[(c * CLIP_FRAMES + k) * ACTION_BODY + b];

        sum += d * d;
    }
    return sqrt(sum);
}

/* Bones keep their lengths; whoever stands has his head above his pelvis, and that above his feet. */
START_TEST(bones)
{
    static const int bone[][2] = { { 8, 10 }, { 10, 12 }, { 9, 11 }, { 11, 13 }, { 1, 3 }, { 3, 5 }, { 25, 26 },
                                   { 49, 50 }, { 62, 63 } };
    const clip c = make(_i, 0);

    for (size_t i = 0; i < LT_COUNT(bone); i++)
        for (int k = 1; k < c.frames; k++)
            ck_assert_double_eq_tol(between(k, bone[i][0], bone[i][1]), between(0, bone[i][0], bone[i][1]), 2e-3);
    for (int k = 0; k < c.frames; k++) {
        const float *y = body + (CLIP_FRAMES + k) * ACTION_BODY;

        ck_assert(y[24] < y[7] && y[7] < y[0] && y[0] < y[3] && y[3] < y[5] && y[5] < 0);
        ck_assert_double_eq_tol(between(k, 12, 25), between(k, 13, 45), 1e-3);
    }
    ck_assert(c.frames >= 60 && c.frames <= CLIP_FRAMES && c.onset < c.frames / 5);
}
END_TEST

/* Reaching and receiving differ in nothing but the hand; at a difficulty of 1 the hand tells late. */
START_TEST(the_same_arm)
{
    action_style style;
    lt_rng a = lt_rng_make(SEED, 1), b, s = lt_rng_make(SEED, 2);
    action_draw reach, receive;
    body_pose p, q;

    b = a;
    action_style_draw(&s, &style);
    action_draw_new(&a, REACHING, 1, &style, &reach);
    action_draw_new(&b, RECEIVING, 1, &style, &receive);
    ck_assert_int_eq(reach.frames, receive.frames);
    for (int k = 0; k < reach.frames; k++) {
        const int arm = reach.arm;

        action_pose(&style, &reach, k, &p);
        action_pose(&style, &receive, k, &q);
        for (int c = 0; c < 3; c++)
            ck_assert_double_eq(p.arm[arm].wrist[c], q.arm[arm].wrist[c]);
        if (k < 0.6 * reach.frames)
            ck_assert_double_eq(p.arm[arm].bend[1], q.arm[arm].bend[1]);
    }
    ck_assert_double_gt(p.arm[reach.arm].bend[1], q.arm[reach.arm].bend[1] + 0.5);
}
END_TEST

static int known(const clip *c)
{
    int n = 0;

    for (int k = 0; k < c->frames; k++)
        n += valid[k];
    return n;
}

START_TEST(objects)
{
    clip c = make(REACHING, 0);
    int most;

    ck_assert_int_eq(known(&c), 0);
    c = make(PICKING, 0);
    most = known(&c);
    ck_assert_int_gt(most, c.frames / 2);
    ck_assert(!valid[0] && valid[c.frames - 1]);
    for (int k = 0; k < c.frames; k++)
        ck_assert((hand_object[k * ACTION_HAND_OBJECT] == 0) == !valid[k]);
    c = make(PICKING, 1);
    ck_assert_int_lt(known(&c), most);
}
END_TEST

/* Steps of a standing head: at a difficulty they are longer. */
START_TEST(noise)
{
    double step[2] = { 0, 0 };

    for (int d = 0; d < 2; d++) {
        const clip c = make(5, d);

        for (int k = 1; k < c.frames; k++)
            step[d] += fabs((double)body[k * ACTION_BODY + 24] - (double)body[(k - 1) * ACTION_BODY + 24]) / c.frames;
    }
    ck_assert_double_lt(step[0], 0.004);
    ck_assert_double_gt(step[1], 0.01);
}
END_TEST

static void generate(const char *out, double difficulty)
{
    check_ok(synth_generate(&(synth_options){ .preset = SYNTH_ACTIONS, .out = in_folder(out), .seed = SEED,
                                              .clips = 100, .difficulty = difficulty }, NULL, NULL));
}

START_TEST(files)
{
    static const char *const names[] = { "body.npy", "hand_object.npy", "valid.npy", "label.json", "manifest.json" };
    lt_arena *arena = lt_arena_new();
    action_set set;
    int64_t n[ACTION_CLASSES] = { 0 };

    make_scratch_folder();
    generate("a", 0.25);
    lt_set_threads(3);
    generate("b", 0.25);
    for (size_t i = 0; i < LT_COUNT(names); i++) {
        uint8_t *x, *y;
        size_t n_x, n_y;

        check_ok(lt_read_file(arena, in_folder(lt_arena_printf(arena, "a/%s", names[i])), LT_FILE_MAX, &x, &n_x));
        check_ok(lt_read_file(arena, in_folder(lt_arena_printf(arena, "b/%s", names[i])), LT_FILE_MAX, &y, &n_y));
        ck_assert(n_x == n_y && memcmp(x, y, n_x) == 0);
    }
    check_ok(action_open(arena, in_folder("a"), &set));
    ck_assert_int_eq(set.n, 100);
    ck_assert_int_eq(set.subjects, ACTIONS_SUBJECTS);
    ck_assert(set.synthetic);
    ck_assert_double_eq(set.difficulty, 0.25);
    for (int64_t i = 0; i < set.n; i++)
        n[set.clip[i].cls]++;
    for (int i = 0; i < ACTION_CLASSES; i++)
        ck_assert_int_eq(n[i], 10);
    check_error(synth_generate(&(synth_options){ .preset = SYNTH_ACTIONS, .out = in_folder("c"), .clips = 150 }, NULL,
                               NULL), LT_EINVAL, "150 clips: preset actions has 10 subjects and 10 actions");
    lt_arena_free(arena);
    remove_scratch_folder();
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 120);
    tcase_add_loop_test(tc, bones, 0, ACTION_CLASSES);
    tcase_add_test(tc, the_same_arm);
    tcase_add_test(tc, objects);
    tcase_add_test(tc, noise);
    tcase_add_test(tc, files);
}

int main(void)
{
    return run_suite("actions", add_tests);
}
