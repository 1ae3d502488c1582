/* SPDX-License-Identifier: Apache-2.0 */
/* The scores of trackers: cases by hand, and scripts/vectors/track_scores.py's after TrackEval. */
#include "eval/metrics/track.h"
#include "eval/scorers/mot.h"
#include "libtensor/io/array/npz.h"
#include "tests/suite.h"

#include <math.h>

static track_scores score(const track_scored_frame *frame, int64_t n)
{
    track_counts c;

    check_ok(track_count(frame, n, &c));
    return track_scores_of(&c);
}

static void check_scores(track_scores s, const double want[7])
{
    const double got[7] = { s.hota, s.deta, s.assa, s.mota, s.idf1, s.switches, s.taken };
    static const char *const name[7] = { "hota", "deta", "assa", "mota", "idf1", "switches", "taken" };

    for (int k = 0; k < 7; k++)
        ck_assert_msg(fabs(got[k] - want[k]) < 1e-12, "%s is %.15g, want %.15g", name[k], got[k], want[k]);
}

static track_scored at(int64_t id, double x)
{
    return (track_scored){ id, id, { x, 0, x + 10, 10 } };
}

/* ---- by hand ---- */

enum { FRAMES = 4 };

static track_scored truth[FRAMES], found[FRAMES];
static track_scored_frame film[FRAMES];

/* One thing in four frames, found exactly */
static void setup(void)
{
    for (int f = 0; f < FRAMES; f++) {
        truth[f] = at(7, 5 * f);
        found[f] = at(-2, 5 * f);
        film[f] = (track_scored_frame){ &truth[f], &found[f], 1, 1 };
    }
}

START_TEST(perfect)
{
    check_scores(score(film, FRAMES), (double[]){ 1, 1, 1, 1, 1, 0, 0 });
}
END_TEST

/* Two frames under one id, two under another: each pair of ids shares 2 of the 4 frames that either has. */
START_TEST(one_switch)
{
    found[2].id = found[3].id = 9;
    check_scores(score(film, FRAMES), (double[]){ sqrt(0.5), 1, 0.5, 0.75, 0.5, 1, 0 });
}
END_TEST

/* A frame without the truth or without anything found is no history: the switch is seen all the same, once. */
START_TEST(switch_over_a_gap)
{
    found[2].id = found[3].id = 9;
    film[1].n_found = 0;
    check_scores(score(film, FRAMES), (double[]){ sqrt(0.75 * (1.0 / 4 + 2 * 2.0 / 4) / 3), 0.75,
                                                  (1.0 / 4 + 2 * 2.0 / 4) / 3, (3 - 1) / 4.0, 2 / (2 + 1.5), 1, 0 });
}
END_TEST

/* An IoU of 0.6 counts at the 12 thresholds from 0.05 to 0.6. */
START_TEST(thresholds)
{
    for (int f = 0; f < FRAMES; f++)
        found[f].box[0] += 2.5, found[f].box[2] += 2.5;
    check_scores(score(film, FRAMES), (double[]){ 12.0 / 19, 12.0 / 19, 12.0 / 19, 1, 1, 0, 0 });
}
END_TEST

/* CLEAR holds to the pair of the frame before, though another box lies nearer. */
START_TEST(continues)
{
    track_scored two[2] = { at(1, 102), at(2, 100) };
    const track_scored_frame frames[2] = { { &truth[0], &two[0], 1, 1 }, { &truth[0], two, 1, 2 } };

    truth[0] = at(7, 100);
    ck_assert_double_eq(score(frames, 2).switches, 0);
    ck_assert_double_eq(score((track_scored_frame[]){ frames[1], { &truth[0], &two[0], 1, 1 } }, 2).switches, 1);
}
END_TEST

/* Two change their ids: twice somebody is taken for another, once each id is taken over, but not by a twin. */
START_TEST(exchange)
{
    for (int64_t look = 1; look <= 2; look++) {
        track_scored who[2] = { at(1, 0), at(2, 40) };
        const track_scored is[2] = { at(5, 0), at(6, 40) }, then[2] = { at(6, 0), at(5, 40) };
        const track_scored_frame frames[3] = { { who, is, 2, 2 }, { who, then, 2, 2 }, { who, then, 2, 2 } };
        track_scores s;

        who[0].look = 1;
        who[1].look = look;
        s = score(frames, 3);
        ck_assert_double_eq(s.switches, 2);
        ck_assert_double_eq(s.taken, look == 1 ? 0 : 2);
    }
}
END_TEST

START_TEST(nothing)
{
    check_scores(score(NULL, 0), (double[]){ 0, 0, 0, 0, 0, 0, 0 });
    for (int f = 0; f < FRAMES; f++)
        film[f].n_found = 0;
    check_scores(score(film, FRAMES), (double[]){ 0, 0, 0, 0, 0, 0, 0 });
    for (int f = 0; f < FRAMES; f++)
        film[f] = (track_scored_frame){ &truth[f], &found[f], 0, 1 };
    check_scores(score(film, FRAMES), (double[]){ 0, 0, 0, -4, 0, 0, 0 });
}
END_TEST

START_TEST(bad)
{
    track_scored two[2] = { at(5, 0), at(5, 40) };
    const track_scored_frame twice = { two, two, 1, 2 };
    track_counts c;

    check_error(track_count(&twice, 1, &c), LT_EINVAL, "frame 1: identity 5 is there twice, expected once");
    found[3].box[2] = NAN;
    check_error(track_count(film, FRAMES, &c), LT_EINVAL, "frame 4: the box of identity -2 is not finite");
    found[3] = (track_scored){ -2, 0, { 5, 5, 5, 5 } };           /* no area: found, and nothing's */
    ck_assert_double_eq(score(film, FRAMES).mota, 0.5);
}
END_TEST

/* ---- MOTChallenge's rules ---- */

/* A reflection (12), a car (3), a vehicle (6) and somebody who is not scored: of results on these, those on the first
 * count for nothing, and on the third in MOT20. */
START_TEST(challenge)
{
    const mot_box truth_of[] = {
        { .id = 1, .box = { 0, 0, 10, 10 }, .cls = 1, .scored = true },
        { .id = 2, .box = { 20, 0, 30, 10 }, .cls = 12 },
        { .id = 3, .box = { 40, 0, 50, 10 }, .cls = 3, .scored = true },
        { .id = 4, .box = { 60, 0, 70, 10 }, .cls = 6 },
        { .id = 5, .box = { 80, 0, 90, 10 }, .cls = 1 },
    };
    const mot_looks nobody = { NULL, 0 };
    mot_box results[5];
    const mot_frame of_truth = { truth_of, 5 }, of_results = { results, 5 };
    track_counts c;

    for (int i = 0; i < 5; i++) {
        results[i] = truth_of[i];
        results[i].box[2]++;
    }
    check_ok(mot_count("MOT17-02", &nobody, &of_truth, &of_results, 1, &c));
    ck_assert_double_eq(c.clear_tp, 1);
    ck_assert_double_eq(c.clear_fn, 0);
    ck_assert_double_eq(c.clear_fp, 3);
    check_ok(mot_count("MOT20-01", &nobody, &of_truth, &of_results, 1, &c));
    ck_assert_double_eq(c.clear_fp, 2);
    results[1].id = 1;
    results[2].id = 1;
    check_error(mot_count("seq", &nobody, &of_truth, &of_results, 1, &c), LT_EINVAL,
                "seq: frame 1: identity 1 is there twice");
}
END_TEST

/* ---- sequences ---- */

enum { SEQUENCES = 4, LENGTH = 40, MOST = 16 };

static track_scored boxes[2][SEQUENCES][LENGTH][MOST];
static track_scored_frame sequences[SEQUENCES][LENGTH];

static void read_boxes(const lt_npz *npz, const char *name, int side)
{
    const lt_array *a;

    check_ok(lt_npz_get(npz, name, &a));
    for (size_t k = 0; k < lt_array_count(a) / 7; k++) {
        const int64_t s = lt_array_int(a, 7 * k), f = lt_array_int(a, 7 * k + 1);
        track_scored_frame *to = &sequences[s][f];
        int *n = side ? &to->n_found : &to->n_truth;
        track_scored *b = &boxes[side][s][f][(*n)++];

        b->id = lt_array_int(a, 7 * k + 2);
        b->look = (b->id - 3) / 10 / 2;             /* twins, as the script has them */
        for (size_t c = 0; c < 4; c++)
            b->box[c] = lt_array_get(a, 7 * k + 3 + c);
        to->truth = boxes[0][s][f];
        to->found = boxes[1][s][f];
    }
}

START_TEST(as_trackeval)
{
    const char *srcdir = getenv("srcdir");
    lt_arena *arena = lt_arena_new();
    track_counts all = { .switches = 0 }, c;
    const lt_array *want, *deta, *assa;
    lt_npz npz;

    check_ok(lt_npz_read(arena, lt_arena_printf(arena, "%s/tests/vectors/track_scores.npz", srcdir ? srcdir : ".."),
                         &npz));
    read_boxes(&npz, "truth", 0);
    read_boxes(&npz, "found", 1);
    check_ok(lt_npz_get(&npz, "scores", &want));
    check_ok(lt_npz_get(&npz, "deta", &deta));
    check_ok(lt_npz_get(&npz, "assa", &assa));
    for (size_t s = 0; s <= SEQUENCES; s++) {
        double row[7];

        for (size_t k = 0; k < 7; k++)
            row[k] = lt_array_get(want, 7 * s + k);
        if (s < SEQUENCES)
            check_ok(track_count(sequences[s], LENGTH, &c));
        check_scores(track_scores_of(s < SEQUENCES ? &c : &all), row);
        track_counts_add(&all, &c);
        if (s + 1 == SEQUENCES)
            for (size_t a = 0; a < TRACK_ALPHAS; a++) {
                ck_assert_double_eq_tol(all.tp[a] / (all.tp[a] + all.fn[a] + all.fp[a]), lt_array_get(deta, a), 1e-12);
                ck_assert_double_eq_tol(all.associated[a] / fmax(1, all.tp[a]), lt_array_get(assa, a), 1e-12);
            }
    }
    lt_arena_free(arena);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, NULL);
    tcase_add_test(tc, perfect);
    tcase_add_test(tc, one_switch);
    tcase_add_test(tc, switch_over_a_gap);
    tcase_add_test(tc, thresholds);
    tcase_add_test(tc, continues);
    tcase_add_test(tc, exchange);
    tcase_add_test(tc, nothing);
    tcase_add_test(tc, bad);
    tcase_add_test(tc, challenge);
    tcase_add_test(tc, as_trackeval);
}

int main(void)
{
    return run_suite("track", add_tests);
}
