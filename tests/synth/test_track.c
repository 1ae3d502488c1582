/* SPDX-License-Identifier: Apache-2.0 */
/* Films for trackers: their files, who is in them, how things move, and the detections' noise. */
#include "libtensor/io/file.h"
#include "libtensor/io/image/coco_rle.h"
#include "libtensor/io/text/json.h"
#include "synth/track/events.h"
#include "synth/track/noise.h"
#include "synth/track/script.h"
#include "synth/track/track.h"
#include "tests/synth/made.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FOLDERS = TRACK_HALLS + 2 * (TRACK_FILMS - TRACK_HALLS) };

/* One dataset for all tests: a frame of each film. */
static void setup(void)
{
    open_scratch();
    check_ok(synth_generate(&(synth_options){ .preset = SYNTH_TRACK, .out = at("data"), .seed = 5,
                                              .frames = TRACK_FILMS }, NULL, NULL));
}

static const char *text_of(const char *path)
{
    uint8_t *bytes;
    size_t n;

    check_ok(lt_read_file(arena, at(path), LT_FILE_MAX, &bytes, &n));
    return lt_arena_printf(arena, "%.*s", (int)n, (const char *)bytes);
}

/* ---- files ---- */

START_TEST(every_file_is_in_the_manifest)
{
    ck_assert_int_eq(check_manifest("track", "5"), TRACK_FILMS + 5 * FOLDERS + 2);
}
END_TEST

START_TEST(a_class_that_has_no_pictures_says_where_they_are)
{
    ck_assert_str_eq(text_of("data/train/table-01_object/seqinfo.ini"),
                     "[Sequence]\nname=table-01_object\nimDir=../table-01_hand/img1\nframeRate=30\nseqLength=1\n"
                     "imWidth=512\nimHeight=288\nimExt=.jpg\n");
    ck_assert_str_eq(text_of("data/evaluation/hall-14_person/times.csv"), "frame,time\n1,0.000000\n");
}
END_TEST

/* Every mask lies in a box of the truth, and has its id. */
START_TEST(masks_belong_to_the_truth)
{
    static uint8_t mask[TRACK_WIDTH * TRACK_HEIGHT];
    const char *gt = text_of("data/train/hall-03_person/gt/gt.txt");
    char *line, *rest = lt_arena_strdup(arena, text_of("data/train/hall-03_person/gt/masks.txt"));
    int n = 0;

    while ((line = strtok_r(rest, "\n", &rest))) {
        int frame, id, class, h, w, used, box[4], x1 = 0, inside = 0;
        const char *row;
        ck_assert_int_eq(sscanf(line, "%d %d %d %d %d %n", &frame, &id, &class, &h, &w, &used), 5);
        ck_assert(frame == 1 && class == 2 && h == TRACK_HEIGHT && w == TRACK_WIDTH);
        check_ok(lt_rle_decode(line + used, h, w, mask));
        row = strstr(gt, lt_arena_printf(arena, "1,%d,", id - 2000));
        ck_assert_ptr_nonnull(row);
        ck_assert_int_eq(sscanf(row, "1,%*d,%d,%d,%d,%d,1,1,", &box[0], &box[1], &box[2], &box[3]), 4);
        for (int i = 0; i < w * h; i++)
            if (mask[i]) {
                inside += i % w >= box[0] - 1 && i % w < box[0] - 1 + box[2] && i / w >= box[1] - 1 &&
                          i / w < box[1] - 1 + box[3];
                x1++;
            }
        ck_assert_int_eq(inside, x1);
        ck_assert_int_gt(inside, 0);
        n++;
    }
    ck_assert_int_gt(n, 0);
}
END_TEST

/* ---- who ---- */

START_TEST(twins_share_a_shape_or_clothes)
{
    int shapes[2] = { 0 }, clothes[2] = { 0 };

    for (int i = 0; i < TRACK_PEOPLE; i++) {
        const int new = i >= TRACK_TRAIN_PEOPLE;
        int body, dress;
        track_identity(i, &body, &dress);
        ck_assert(body == i || dress == i);
        ck_assert_int_eq(body >= TRACK_TRAIN_PEOPLE, new);
        ck_assert_int_eq(dress >= TRACK_TRAIN_PEOPLE, new);
        shapes[new] += body != i;
        clothes[new] += dress != i;
    }
    ck_assert(shapes[0] == 4 && clothes[0] == 4 && shapes[1] == 2 && clothes[1] == 2);
}
END_TEST

/* ---- motion ---- */

static bool near(double a, double b)
{
    return fabs(a - b) < 1e-9;
}

/* Nobody jumps; who hides stands still behind a screen of a lane before his; who leaves has left. */
START_TEST(things_move_smoothly)
{
    static const track_screen screen[TRACK_SCREENS] = { { -0.4, 1 }, { 0.5, 2 } };
    enum { N = 420 };
    double time[N];
    track_point p[N];

    for (int k = 0; k < N; k++)
        time[k] = k / 30.0;
    for (int seed = 0; seed < 40; seed++) {
        const track_act first = seed % 2 ? TRACK_HIDE : TRACK_LEAVE;
        lt_rng r = lt_rng_make((uint64_t)seed, 3);
        bool there = false;
        track_path_draw(&r, 3, screen, first, time, N, p);
        ck_assert(fabs(p[0].x) <= 0.8);
        for (int k = 1; k < N; k++) {
            ck_assert(fabs(p[k].x - p[k - 1].x) < 0.035);
            there = there || (p[k].speed == 0 && (seed % 2 ? near(p[k].x, -0.4) || near(p[k].x, 0.5)
                                                           : near(fabs(p[k].x), 1.5)));
        }
        ck_assert(there);
    }
}
END_TEST

/* ---- detections ---- */

START_TEST(noise_is_as_large_as_said)
{
    static const synth_mot_truth truth[3] = {
        { 1, { 100, 50, 160, 250 }, 1, NULL }, { 2, { 300, 40, 340, 200 }, 0.3, NULL },
        { 3, { 10, 10, 20, 20 }, 0.09, NULL },
    };
    lt_rng r = lt_rng_make(1, 1);
    track_noise noise = { 0 };
    synth_mot_detection d[6];

    for (int k = 0; k < 20000; k++) {
        const int n = track_detect(&r, truth, 3, TRACK_WIDTH, TRACK_HEIGHT, d, &noise);
        for (int i = 1; i < n; i++)
            ck_assert(d[i].score <= d[i - 1].score && d[i].x1 > d[i].x0);
    }
    ck_assert_int_eq((int)noise.boxes, 40000);
    ck_assert_double_eq_tol((double)noise.missed / 40000, 0.08, 0.006);
    ck_assert_double_eq_tol((double)noise.false_boxes / 40000, 0.03, 0.004);
    ck_assert_double_eq_tol(sqrt(noise.corners / (double)noise.n_corners), 0.03, 0.0005);
}
END_TEST

/* One passes behind another for 1.5 s; then it is gone for a second. */
START_TEST(events_are_counted)
{
    synth_mot_truth t[2] = { { 7, { 0, 0, 10, 20 }, 1, NULL }, { 9, { 50, 0, 60, 20 }, 1, NULL } };
    track_events e = { 0 };
    track_watch w = { .n = 0 };

    for (int k = 0; k < 150; k++) {
        const bool hidden = k >= 30 && k < 75, gone = k >= 90 && k < 120;
        t[1].box.x0 = hidden ? 2 : 50;
        t[1].box.x1 = t[1].box.x0 + 10;
        t[1].visible = hidden ? 0.1 : 1;
        track_events_add(&e, &w, t, gone ? 1 : 2, k / 30.0);
    }
    ck_assert(e.crossings == 1 && e.occlusions == 1 && e.returns == 1);
}
END_TEST

static void add_tests(TCase *c)
{
    tcase_add_unchecked_fixture(c, setup, close_scratch);
    tcase_set_timeout(c, 0);
    tcase_add_test(c, every_file_is_in_the_manifest);
    tcase_add_test(c, a_class_that_has_no_pictures_says_where_they_are);
    tcase_add_test(c, masks_belong_to_the_truth);
    tcase_add_test(c, twins_share_a_shape_or_clothes);
    tcase_add_test(c, things_move_smoothly);
    tcase_add_test(c, noise_is_as_large_as_said);
    tcase_add_test(c, events_are_counted);
}

int main(void)
{
    setenv("CK_FORK", "no", 1);         /* the threads that parallel loops leave do not survive a fork */
    return run_suite("track", add_tests);
}
