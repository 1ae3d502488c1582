/* SPDX-License-Identifier: Apache-2.0 */
/* Assignment and trackers: cases by hand, and scripts/vectors/tracker.py's after NumPy and SciPy. */
#include "libtensor/io/array/npz.h"
#include "tests/suite.h"
#include "vision/assignment.h"
#include "vision/track/tracker.h"

#include <math.h>

static lt_arena *arena;
static lt_npz npz;

static void setup(void)
{
    const char *srcdir = getenv("srcdir");

    arena = lt_arena_new();
    check_ok(lt_npz_read(arena, lt_arena_printf(arena, "%s/tests/vectors/tracker.npz", srcdir ? srcdir : ".."), &npz));
}

static void teardown(void)
{
    lt_arena_free(arena);
}

static const lt_array *get(const char *name)
{
    const lt_array *a;

    check_ok(lt_npz_get(&npz, name, &a));
    return a;
}

/* ---- assignment ---- */

START_TEST(assignment)
{
    const lt_array *size = get("size"), *cost = get("cost"), *least = get("least");

    for (size_t k = 0; k < lt_array_count(least); k++) {
        const int rows = (int)lt_array_get(size, 2 * k), cols = (int)lt_array_get(size, 2 * k + 1);
        double c[49], sum = 0;
        int column[7], pairs = 0;
        bool taken[7] = { false };

        for (int i = 0; i < rows; i++)
            for (int j = 0; j < cols; j++)
                c[i * cols + j] = lt_array_get(cost, 49 * k + (size_t)(7 * i + j));
        check_ok(assignment_solve(arena, c, rows, cols, column));
        for (int i = 0; i < rows; i++) {
            if (column[i] < 0)
                continue;
            ck_assert(!taken[column[i]]);
            taken[column[i]] = true;
            sum += c[i * cols + column[i]];
            pairs++;
        }
        ck_assert_int_eq(pairs, rows < cols ? rows : cols);
        ck_assert_double_eq_tol(sum, lt_array_get(least, k), 1e-9);
    }
}
END_TEST

START_TEST(assignment_of_nothing)
{
    int column[2] = { 5, 5 };

    check_ok(assignment_solve(arena, NULL, 0, 3, NULL));
    check_ok(assignment_solve(arena, NULL, 2, 0, column));
    ck_assert_int_eq(column[0], -1);
    ck_assert_int_eq(column[1], -1);
}
END_TEST

/* ---- a film ---- */

enum { SIZE = 16, MOST = 16 };

typedef struct { track_detection found[MOST]; float look[MOST][SIZE]; int n; } frame;

/* all: those too that are not kept */
static void read_frame(double f, bool all, frame *out)
{
    const lt_array *found = get("found"), *look = get("look"), *kept = get("kept");

    out->n = 0;
    for (size_t i = 0; i < lt_array_count(found) / 7; i++) {
        track_detection *d = &out->found[out->n];

        if (lt_array_get(found, 7 * i) != f || !(all || lt_array_get(kept, i) > 0))
            continue;
        for (size_t c = 0; c < 4; c++)
            d->box[c] = (float)lt_array_get(found, 7 * i + 1 + c);
        d->score = (float)lt_array_get(found, 7 * i + 5);
        d->cls = (int)lt_array_get(found, 7 * i + 6);
        d->embedding = out->look[out->n];
        for (size_t c = 0; c < SIZE; c++)
            out->look[out->n][c] = (float)lt_array_get(look, SIZE * i + c);
        out->n++;
    }
}

static void check_box(const lt_array *want, size_t row, size_t f, const tracked_box *b)
{
    ck_assert_msg(lt_array_get(want, 8 * row) == (double)f && lt_array_get(want, 8 * row + 1) == (double)b->id,
                  "frame %zu has track %d, want %g in %g", f, (int)b->id, lt_array_get(want, 8 * row + 1),
                  lt_array_get(want, 8 * row));
    ck_assert_double_eq(lt_array_get(want, 8 * row + 2), b->cls);
    ck_assert_double_eq(lt_array_get(want, 8 * row + 3), b->detection);
    for (size_t c = 0; c < 4; c++)
        ck_assert_double_eq_tol(lt_array_get(want, 8 * row + 4 + c), (double)b->box[c], 1e-3);
}

static const struct {
    const char *name;
    track_method method;
    int embedding;
    bool all;
} films[] = {
    { "deepsort", TRACK_DEEPSORT, SIZE, true }, { "byte", TRACK_BYTE, SIZE, true }, { "plain", TRACK_BYTE, 0, true },
    { "iou", TRACK_IOU, SIZE, true }, { "deepsort_looks", TRACK_DEEPSORT, SIZE, false },
    { "byte_looks", TRACK_BYTE, SIZE, false },
};

START_TEST(as_numpy)
{
    const lt_array *want = get(films[_i].name), *times = get("times");
    tracker_options o = films[_i].all ? tracker_as_published : tracker_defaults;
    size_t row = 0;
    tracker *t;

    o.method = films[_i].method;
    o.embedding = films[_i].embedding;
    check_ok(tracker_new(&o, &t));
    for (size_t f = 0; f < lt_array_count(times); f++) {
        const tracked_box *b;
        frame at;
        int n;

        read_frame((double)f, films[_i].all, &at);
        check_ok(tracker_step(t, lt_array_get(times, f), at.found, at.n, &b, &n));
        for (int i = 0; i < n; i++)
            check_box(want, row++, f, &b[i]);
    }
    ck_assert_uint_eq(row, lt_array_count(want) / 8);
    tracker_free(t);
}
END_TEST

/* ---- by hand ---- */

static const float red[2] = { 1, 0 }, blue[2] = { 0, 3 };
static const tracked_box *seen;
static int n_seen;

static tracker *make(track_method method)
{
    tracker_options o = tracker_defaults;
    tracker *t;

    o.method = method;
    o.embedding = 2;
    check_ok(tracker_new(&o, &t));
    return t;
}

static track_detection at(float x, const float *look)
{
    return (track_detection){ .box = { x, 0, x + 40, 80 }, .score = 0.9f, .embedding = look };
}

static void step(tracker *t, double k, const track_detection *d, int n)
{
    check_ok(tracker_step(t, k / 30, d, n, &seen, &n_seen));
}

static const tracked_box *of(int detection)
{
    for (int i = 0; i < n_seen; i++)
        if (seen[i].detection == detection)
            return &seen[i];
    return NULL;
}

/* Two meet and turn round. By overlap alone they are taken for each other; by looks they are not, nor by those alone
 * that are in doubt: few of them, while they are apart. */
START_TEST(crossing)
{
    const bool looks = _i != 1;
    tracker *t = make(looks ? TRACK_DEEPSORT : TRACK_IOU);
    int64_t id[2] = { 0, 0 };
    int spared = 0;

    for (int k = 0; k < 60; k++) {
        const float x = k < 30 ? (float)(4 * k) : (float)(4 * (60 - k));
        track_detection d[] = { at(x, red), at(236 - x, blue) };
        bool doubt[2] = { true, true };

        if (_i == 2)
            tracker_doubts(t, d, 2, doubt);
        for (int i = 0; i < 2; i++) {
            d[i].embedding = doubt[i] ? d[i].embedding : NULL;
            spared += !doubt[i];
            ck_assert(doubt[i] || fabsf(d[0].box[0] - d[1].box[0]) > 16);
        }
        step(t, k, d, 2);
        if (k == 5 || k == 55)
            for (int i = 0; i < 2; i++) {
                ck_assert_ptr_nonnull(of(i));
                ck_assert(k == 5 || (of(i)->id == id[i]) == looks);
                id[i] = of(i)->id;
            }
    }
    ck_assert_int_ne(id[0], id[1]);
    ck_assert(_i == 2 ? spared >= 50 : spared == 0);
    tracker_free(t);
}
END_TEST

/* Confirmed at the third hit, shown while missed once, back after 30 misses, gone after 31. */
START_TEST(life)
{
    const int missed = 30 + _i;
    const track_detection d = at(100, red);
    tracker *t = make(TRACK_DEEPSORT);
    int k = 0;

    for (; k < 3; k++) {
        step(t, k, &d, 1);
        ck_assert_int_eq(n_seen, k == 2);
    }
    ck_assert_int_eq(seen[0].id, 1);
    ck_assert_int_eq(seen[0].detection, 0);
    for (; k < 3 + missed; k++) {
        step(t, k, NULL, 0);
        ck_assert_int_eq(n_seen, k == 3);
        ck_assert(!n_seen || seen[0].detection == -1);
    }
    for (; k < 6 + missed; k++)
        step(t, k, &d, 1);
    ck_assert_int_eq(n_seen, 1);
    ck_assert_int_eq(seen[0].id, missed > 29 ? 2 : 1);
    tracker_free(t);
}
END_TEST

/* A tentative track ends at its first miss. */
START_TEST(tentative)
{
    const track_detection d = at(100, red);
    tracker *t = make(TRACK_DEEPSORT);

    for (int k = 0; k < 12; k++) {
        step(t, k, &d, k % 3 != 2);
        ck_assert_int_eq(n_seen, 0);
    }
    tracker_free(t);
}
END_TEST

/* Of two that look alike and fit, the one that was seen last takes the detection, though the other is nearer. */
START_TEST(recent_first)
{
    tracker *t = make(TRACK_DEEPSORT);
    const track_detection both[] = { at(100, red), at(112, red) }, one = at(112, red), between = at(105, red);

    for (int k = 0; k < 4; k++)
        step(t, k, both, 2);
    step(t, 4, &one, 1);
    step(t, 5, &one, 1);
    step(t, 6, &between, 1);
    ck_assert_int_eq(n_seen, 1);
    ck_assert_int_eq(of(0)->id, 2);
    tracker_free(t);
}
END_TEST

/* One is missed in the frame in which another comes out from behind it. Where looks have no say, who comes out is taken
 * for who was missed. */
START_TEST(overlap_of_unlike)
{
    tracker_options o = _i ? tracker_as_published : tracker_defaults;
    const track_detection front = at(100, red), both[] = { at(100, red), at(105, blue) };
    tracker *t;

    o.embedding = 2;
    check_ok(tracker_new(&o, &t));
    for (int k = 0; k < 5; k++)
        step(t, k, &front, 1);
    step(t, 5, &both[1], 1);
    ck_assert(!of(0) == !_i);
    step(t, 6, both, 2);
    ck_assert(_i || (of(0) && of(0)->id == 1 && !of(1)));
    tracker_free(t);
}
END_TEST

/* Hidden for some frames, and then so little of it is seen that its look is another: what is where it should be, and
 * looks like nobody else, is taken for it. */
START_TEST(overlap_of_hidden)
{
    static const float reddish[2] = { 0.7f, 0.714f };           /* 0.3 from red */
    tracker_options o = _i ? tracker_as_published : tracker_defaults;
    const track_detection seen_well = at(100, red), seen_badly = at(100, reddish);
    tracker *t;

    o.embedding = 2;
    check_ok(tracker_new(&o, &t));
    for (int k = 0; k < 5; k++)
        step(t, k, &seen_well, 1);
    for (int k = 5; k < 8; k++)
        step(t, k, NULL, 0);
    step(t, 8, &seen_badly, 1);
    ck_assert(!of(0) == (_i == 1));
    tracker_free(t);
}
END_TEST

/* What is half hidden looks like what hides it, so its place alone tells: it has to be there by 0.6, not by 0.3. */
START_TEST(overlap_of_unsure)
{
    tracker_options o = _i == 2 ? tracker_as_published : tracker_defaults;
    const track_detection before = at(100, red);
    track_detection half = at(_i == 1 ? 108 : 116, blue);       /* IoU 0.67 and 0.43 */
    tracker *t;

    o.embedding = 2;
    check_ok(tracker_new(&o, &t));
    for (int k = 0; k < 5; k++)
        step(t, k, &before, 1);
    half.score = 0.5f;
    step(t, 5, &half, 1);
    ck_assert(!of(0) == (_i == 0));
    tracker_free(t);
}
END_TEST

/* What scores low continues a track of byte's, and starts none. */
START_TEST(low_scores)
{
    tracker *t = make(_i ? TRACK_BYTE : TRACK_DEEPSORT);
    track_detection d[] = { at(100, red), at(300, blue) };

    d[1].score = 0.2f;
    for (int k = 0; k < 20; k++) {
        d[0].score = k < 5 ? 0.9f : 0.2f;
        step(t, k, d, 2);
        ck_assert_ptr_null(of(1));
        ck_assert(k < 6 || n_seen == _i);
    }
    tracker_free(t);
}
END_TEST

/* Two seconds without a frame are 60 frames missed; time that stands still or is none is one frame. */
START_TEST(time_steps)
{
    static const double times[] = { 3, 3, 1, NAN, INFINITY, 4 };
    const track_detection d = at(100, red);
    tracker *t = make(TRACK_IOU);

    for (int k = 0; k < 4; k++)
        step(t, k, &d, 1);
    for (size_t k = 0; k < LT_COUNT(times); k++) {
        step(t, times[k], &d, 1);
        ck_assert_int_eq(n_seen, 1);
        ck_assert_int_eq(seen[0].id, 1);
    }
    step(t, 64, &d, 1);
    ck_assert_int_eq(n_seen, 0);
    tracker_free(t);
}
END_TEST

/* Boxes that are none pass unseen, and classes keep to themselves. */
START_TEST(odd_detections)
{
    const float nan_look[2] = { NAN, 1 }, no_look[2] = { 0, 0 }, large = 3e38f;
    const track_detection d[] = {
        at(100, nan_look), at(200, NULL), at(300, no_look), at(NAN, red), at(INFINITY, red),
        { .box = { 5, 5, 5, 9 }, .score = 0.9f }, { .box = { 9, 5, 5, 9 }, .score = 0.9f },
        { .box = { 5, 5, 9, 9 }, .score = NAN }, { .box = { -large, -large, large, large }, .score = 0.9f },
        { .box = { 0, 0, large, 1e-30f }, .score = 0.9f }, { .box = { 0, 0, large, large }, .score = 0.9f, .cls = -4 },
    };
    tracker *t = make(_i ? TRACK_BYTE : TRACK_DEEPSORT);

    for (int k = 0; k < 5; k++)
        step(t, k, d, (int)LT_COUNT(d));
    ck_assert_int_eq(n_seen, 4);
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(seen[i].detection, i);
    ck_assert_int_eq(seen[3].cls, -4);
    tracker_free(t);
}
END_TEST

START_TEST(bad_options)
{
    tracker_options o = tracker_defaults;
    tracker *t = NULL;

    o.embedding = 0;
    check_error(tracker_new(&o, &t), LT_EINVAL, "deepsort compares embeddings");
    o = tracker_defaults;
    o.fps = 0;
    check_error(tracker_new(&o, &t), LT_EINVAL, "fps is 0");
    o = tracker_defaults;
    o.budget = 0;
    check_error(tracker_new(&o, &t), LT_EINVAL, "budget 0");
    o = tracker_defaults;
    o.max_iou = NAN;
    check_error(tracker_new(&o, &t), LT_EINVAL, "expected 0 to 2");
    ck_assert_ptr_null(t);
}
END_TEST

/* Each time another block is refused, and the film goes on. */
START_TEST(without_memory)
{
    const track_detection d[] = { at(100, red), at(300, blue), at(500, NULL) };
    bool failed = true;

    for (long k = 1; failed; k++) {
        tracker_options o = tracker_defaults;
        tracker *t = NULL;

        o.embedding = 2;
        lt_alloc_fail_at(k);
        failed = tracker_new(&o, &t) != LT_OK;
        for (int f = 0; t && f < 6; f++)
            failed |= tracker_step(t, f / 30.0, d, 3, &seen, &n_seen) != LT_OK;
        lt_alloc_fail_at(0);
        tracker_free(t);
    }
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_add_test(tc, assignment);
    tcase_add_test(tc, assignment_of_nothing);
    tcase_add_loop_test(tc, as_numpy, 0, (int)LT_COUNT(films));
    tcase_add_loop_test(tc, crossing, 0, 3);
    tcase_add_loop_test(tc, life, -1, 2);
    tcase_add_test(tc, tentative);
    tcase_add_test(tc, recent_first);
    tcase_add_loop_test(tc, overlap_of_unlike, 0, 2);
    tcase_add_loop_test(tc, overlap_of_hidden, 0, 2);
    tcase_add_loop_test(tc, overlap_of_unsure, 0, 3);
    tcase_add_loop_test(tc, low_scores, 0, 2);
    tcase_add_test(tc, time_steps);
    tcase_add_loop_test(tc, odd_detections, 0, 2);
    tcase_add_test(tc, bad_options);
    tcase_add_test(tc, without_memory);
}

int main(void)
{
    return run_suite("tracker", add_tests);
}
