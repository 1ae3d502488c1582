/* SPDX-License-Identifier: Apache-2.0 */
/*
 * soak DETECTOR PICTURE MINUTES: watch through two cameras that give pictures faster than they can be looked at, for as
 * long as is said, and hold it to this: ages stay where they were, memory too, and captured = taken + dropped.
 */
#include "estimate/detection/detector.h"
#include "libtensor/base/clock.h"
#include "libtensor/base/resident.h"
#include "libtensor/kernels/kernels.h"
#include "pipeline/watch/watch.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { CAMERAS = 2 };
static const double FPS = 240;                 /* more than any two cores look at */
static const double MOST_AGE_MS = 500, MOST_GROWTH = 1.1;

typedef struct {
    const lt_image *picture;
    double began, until;
    int64_t frame;
} endless;

/* The picture, a little darker or lighter each time */
static lt_status next(void *state, lt_arena *arena, watch_picture *out, bool *more)
{
    endless *s = state;
    const double due = s->began + (double)s->frame / FPS, wait = due - lt_clock();
    const struct timespec nap = { .tv_nsec = (long)(1e9 * (wait > 0 ? wait : 0)) };
    lt_status st;

    nanosleep(&nap, NULL);
    *more = due < s->until;
    *out = (watch_picture){ .t = (double)s->frame / FPS, .line = -1 };
    st = lt_image_init(arena, s->picture->width, s->picture->height, 3, 8, &out->rgb);
    for (size_t i = 0; !st && i < lt_image_bytes(&out->rgb); i++)
        out->rgb.data[i] = (uint8_t)(s->picture->data[i] / 2 + s->frame % 100);
    s->frame++;
    return st;
}

static const watch_camera_kind kind = { .next = next };

static double rss_after_minute;

static void by_the_minute(int64_t sets, double t)
{
    static double last;

    if (t - last < 60)
        return;
    last = t;
    if (!(rss_after_minute > 0))
        rss_after_minute = (double)lt_resident();
    printf("%4.0f s  %8lld sets  %6.1f MB\n", t, (long long)sets, 1e-6 * (double)lt_resident());
    fflush(stdout);
}

static int fail(const char *what)
{
    fprintf(stderr, "soak: %s\n", what);
    return 1;
}

static int check(const watch_summary *sum)
{
    printf("%lld captured, %lld taken, %lld dropped, %.1f sets a second, age %.0f ms, 95 %% within %.0f ms, %.1f MB\n",
           (long long)sum->captured, (long long)sum->taken, (long long)sum->dropped, sum->fps, sum->age_p50_ms,
           sum->age_p95_ms, sum->rss_last_mb);
    if (sum->captured != sum->taken + sum->dropped)
        return fail("frames are not all counted");
    if (!sum->dropped)
        return fail("nothing was dropped: that was no overload");
    if (!(sum->age_p95_ms < MOST_AGE_MS))
        return fail("ages grew");
    if (rss_after_minute > 0 && 1e6 * sum->rss_last_mb > MOST_GROWTH * rss_after_minute)
        return fail("memory grew");
    return 0;
}

int main(int argc, char **argv)
{
    static const char *const names[CAMERAS] = { "one", "two" };
    lt_arena *arena = lt_arena_new();
    watch_options o = { .progress = by_the_minute, .messages = stderr };
    endless camera[CAMERAS];
    watch_summary sum;
    lt_image picture;
    detector d;

    if (argc != 4 || !arena)
        return fail("want a detector, a picture, and minutes");
    if (lt_kernels_init() || detector_open(argv[1], &d) || lt_image_read(arena, argv[2], &picture) ||
        lt_image_to_rgb8(arena, &picture, &picture))
        return fail(lt_last_error());
    o.models.detector = &d;
    o.rig = (recording_rig){ .n = CAMERAS, .fps = FPS };
    for (int c = 0; c < CAMERAS; c++) {
        const double w = picture.width, h = picture.height;

        camera[c]
            = (endless){ .picture = &picture, .began = lt_clock(), .until = lt_clock() + 60 * strtod(argv[3], NULL) };
        o.rig.camera[c] = (recording_camera){ .name = names[c], .width = picture.width, .height = picture.height,
                                              .K = { 1.2 * w, 1.2 * w, w / 2, h / 2 } };
        o.camera[c] = (watch_camera){ .kind = &kind, .state = &camera[c], .source = names[c], .live = true };
    }
    if (watch_run(&o, &sum))
        return fail(lt_last_error());
    detector_close(&d);
    lt_arena_free(arena);
    return check(&sum);
}
