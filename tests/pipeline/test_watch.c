/* SPDX-License-Identifier: Apache-2.0 */
/* Sessions of watch: cameras that come and go, recordings and their replays, what is kept when something goes wrong. */
#include "pipeline/watch/watch.h"

#include "libtensor/base/parallel.h"
#include "libtensor/io/file.h"
#include "libtensor/kernels/kernels.h"
#include "tests/suite.h"

#include <config.h>
#include <time.h>

enum { WIDTH = 64, HEIGHT = 48 };

static lt_arena *arena;
static char *said, *lines;
static size_t said_n, lines_n;

static void setup(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
    check_ok(lt_kernels_init());
}

static void teardown(void)
{
    lt_arena_free(arena);
    remove_scratch_folder();
}

/* ---- a camera that is none ---- */

typedef struct {
    int frame, frames;              /* then it is unplugged */
    double wait, off, jitter;       /* seconds: from frame to frame, of its clock, by turns more and less */
    uint8_t shade;
} fake;

static lt_status fake_next(void *state, lt_arena *room, watch_picture *out, bool *more)
{
    fake *f = state;
    const struct timespec nap = { .tv_nsec = (long)(1e9 * f->wait) };

    if (f->frame == f->frames)
        return lt_error(LT_EIO, "it was unplugged");
    nanosleep(&nap, NULL);
    *more = true;
    *out = (watch_picture){ .t = f->frame / 30.0 + f->off + (f->frame % 2 ? f->jitter : -f->jitter), .line = -1 };
    f->frame++;
    check_ok(lt_image_init(room, WIDTH, HEIGHT, 3, 8, &out->rgb));
    memset(out->rgb.data, f->shade + 7 * f->frame, (size_t)3 * WIDTH * HEIGHT);
    return LT_OK;
}

static const watch_camera_kind fake_kind = { .next = fake_next };

static void add_fake(watch_options *o, fake *f, bool live)
{
    recording_camera *c = &o->rig.camera[o->rig.n];

    o->rig.fps = 30;
    *c = (recording_camera){ .name = lt_arena_printf(arena, "camera%d", o->rig.n), .width = WIDTH, .height = HEIGHT,
                             .role = o->rig.n ? RECORDING_TABLE : RECORDING_FRONT, .K = { 60, 60, 32, 24 } };
    o->camera[o->rig.n++] = (watch_camera){ .kind = &fake_kind, .state = f, .source = "fake", .live = live };
}

static watch_summary watch(watch_options *o)
{
    FILE *to = open_memstream(&lines, &lines_n), *err = open_memstream(&said, &said_n);
    watch_summary sum;

    o->lines = to;
    o->messages = err;
    check_ok(watch_run(o, &sum));
    fclose(to);
    fclose(err);
    ck_assert_int_eq(sum.captured, sum.taken + sum.dropped);
    return sum;
}

static int count(const char *text, const char *word)
{
    int n = 0;

    for (const char *p = text; (p = strstr(p, word)); p++)
        n++;
    return n;
}

/* ---- live ---- */

START_TEST(one_is_unplugged)
{
    fake a = { .frames = 12, .wait = 0.01 }, b = { .frames = 4, .wait = 0.01 };
    watch_options o = { .fast = false };
    watch_summary sum;

    add_fake(&o, &a, true);
    add_fake(&o, &b, true);
    sum = watch(&o);
    ck_assert_int_eq(sum.captured, 16);
    ck_assert_int_ge(sum.sets, 2);
    ck_assert_ptr_nonnull(strstr(said, "palmar: camera camera1: it was unplugged; the others go on"));
    ck_assert_ptr_nonnull(strstr(said, "palmar: camera camera0: it was unplugged"));
    ck_assert_int_eq(count(lines, "\"schema\": \"palmar.set/1\""), sum.sets);
    ck_assert_int_eq(count(lines, "\"summary\": 1"), 1);
}
END_TEST

/* The one in front goes first: another one is the reference. */
START_TEST(the_reference_is_unplugged)
{
    fake a = { .frames = 2, .wait = 0.01 }, b = { .frames = 9, .wait = 0.01 };
    watch_options o = { .fast = false };

    add_fake(&o, &a, true);
    add_fake(&o, &b, true);
    ck_assert_int_ge(watch(&o).sets, 2);
}
END_TEST

static void slow_progress(int64_t sets, double t)
{
    const struct timespec nap = { .tv_nsec = 40000000 };

    (void)sets;
    (void)t;
    nanosleep(&nap, NULL);
}

/* Ten times slower than the camera: what is looked at is new, the rest is dropped and counted. Were it kept, the last
 * one would be two seconds old. */
START_TEST(overload)
{
    fake a = { .frames = 60, .wait = 0.004 };
    watch_options o = { .progress = slow_progress };
    watch_summary sum;

    add_fake(&o, &a, true);
    sum = watch(&o);
    ck_assert_int_eq(sum.captured, 60);
    ck_assert_int_lt(sum.taken, 30);
    ck_assert(sum.age_p95_ms < 1000);
}
END_TEST

/* ---- as fast as can be ---- */

START_TEST(every_frame_in_pairs)
{
    fake a = { .frames = 20 }, b = { .frames = 20, .off = 0.010, .jitter = 0.004 };
    watch_options o = { .fast = true };
    watch_summary sum;

    add_fake(&o, &a, false);
    add_fake(&o, &b, false);
    sum = watch(&o);
    ck_assert_int_eq(sum.sets, 20);
    ck_assert_int_eq(sum.taken, 40);
    ck_assert_int_eq(count(lines, "null]"), 0);
}
END_TEST

/* Frames that fall between the other camera's go with the nearer one, if that is half a period away at most. */
START_TEST(between_the_others)
{
    fake a = { .frames = 5 }, b = { .frames = 5, .off = 1.0 / 60 + 1e-3 };
    watch_options o = { .fast = true };
    watch_summary sum;

    add_fake(&o, &a, false);
    add_fake(&o, &b, false);
    sum = watch(&o);
    ck_assert_int_eq(sum.captured, sum.taken + sum.dropped);
    ck_assert_int_eq(count(lines, "\"pair_ms\": 0,"), 2);       /* the first of one, the last of the other */
}
END_TEST

START_TEST(some_seconds)
{
    fake a = { .frames = 100 };
    watch_options o = { .fast = true, .seconds = 0.5 };

    add_fake(&o, &a, false);
    ck_assert_int_eq(watch(&o).sets, 15);
}
END_TEST

/* ---- recordings ---- */

static watch_summary replay(const char *root, bool fast)
{
    watch_options o = { .fast = fast };
    watch_summary sum;
    recording r;

    check_ok(recording_open(arena, root, &r));
    o.rig = r.rig;
    o.replayed = &r;
    for (int c = 0; c < r.rig.n; c++)
        check_ok(watch_recording_camera(arena, &r, c, &o.camera[c]));
    sum = watch(&o);
    return sum;
}

/* The sets are those that were taken, at any pace and with any number of threads. */
START_TEST(replays_are_equal)
{
    fake a = { .frames = 10, .wait = 0.005 }, b = { .frames = 10, .wait = 0.005, .off = 0.003 };
    watch_options o = { .record = in_folder("r") };
    watch_summary live, one, four;

    add_fake(&o, &a, true);
    add_fake(&o, &b, true);
    live = watch(&o);
    lt_set_threads(1);
    one = replay(in_folder("r"), true);
    lt_set_threads(4);
    four = replay(in_folder("r"), false);
    ck_assert_int_eq(one.sets, live.sets);
    ck_assert_int_eq(one.taken, live.taken);
    ck_assert_int_eq(one.dropped, 0);
    ck_assert_uint_eq(one.crc32, four.crc32);
    ck_assert(exists(in_folder("r/session.ndjson")) && exists(in_folder("r/camera1/000001.jpg")));
}
END_TEST

/* A frame that was lost ends its camera; a folder that has a recording is left alone. */
START_TEST(damaged_recording)
{
    fake a = { .frames = 6 }, c = { .frames = 3 };
    watch_options o = { .record = in_folder("r"), .fast = true }, again = { .record = in_folder("r"), .fast = true };
    watch_summary sum;
    recording r;

    add_fake(&o, &a, false);
    watch(&o);
    ck_assert_int_eq(remove(in_folder("r/camera0/000004.jpg")), 0);
    ck_assert_int_eq(remove(in_folder("r/sets.jsonl")), 0);
    sum = replay(in_folder("r"), true);
    ck_assert_int_eq(sum.sets, 3);
    ck_assert_ptr_nonnull(strstr(said, "000004.jpg: No such file"));
    add_fake(&again, &c, false);
    check_error(watch_run(&again, &sum), LT_EINVAL, "there is a recording in it");
    check_ok(recording_open(arena, in_folder("r"), &r));
    ck_assert_int_eq(r.n_frames, 6);
}
END_TEST

/* ---- sources ---- */

static lt_status open_sources(const char *a, const char *b)
{
    const char *const sources[] = { a, b };
    watch_camera camera[RECORDING_CAMERAS] = { { .kind = NULL } };
    recording_rig rig = { .n = 0 };
    const lt_status st = watch_cameras_open(arena, sources, b ? 2 : 1, &rig, camera);

    for (int c = 0; c < RECORDING_CAMERAS; c++)
        watch_camera_close(&camera[c]);
    return st;
}

START_TEST(sources)
{
    const lt_image img = { 8, 6, 3, 8, (uint8_t[144]){ 0 } };
    const char *const folder[] = { in_folder("f") };
    watch_options o = { .fast = true };
    watch_summary sum;

    check_ok(lt_make_dirs(in_folder("f")));
    check_error(open_sources(in_folder("f"), NULL), LT_EINVAL, "neither a recording nor a folder with images");
    check_error(open_sources(in_folder("none.mp4"), NULL), LT_EIO, "none.mp4: No such file");
    check_ok(lt_jpeg_write(in_folder("f/2.jpg"), &img, 90));
    check_ok(lt_jpeg_write(in_folder("f/10.jpg"), &img, 90));
    check_ok(watch_cameras_open(arena, folder, 1, &o.rig, o.camera));
    ck_assert_int_eq(o.rig.camera[0].width, 8);
    sum = watch(&o);
    ck_assert_int_eq(sum.sets, 2);
    watch_camera_close(&o.camera[0]);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_add_checked_fixture(tc, setup, teardown);
    tcase_set_timeout(tc, 60);
    tcase_add_test(tc, one_is_unplugged);
    tcase_add_test(tc, the_reference_is_unplugged);
    tcase_add_test(tc, overload);
    tcase_add_test(tc, every_frame_in_pairs);
    tcase_add_test(tc, between_the_others);
    tcase_add_test(tc, some_seconds);
    tcase_add_test(tc, replays_are_equal);
    tcase_add_test(tc, damaged_recording);
    tcase_add_test(tc, sources);
}

int main(void)
{
    return run_suite("watch", add_tests);
}
