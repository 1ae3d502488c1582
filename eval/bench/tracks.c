/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/bench/tracks.h"

#include "libtensor/base/clock.h"
#include "libtensor/base/order.h"
#include "libtensor/base/rng.h"
#include "vision/track/tracker.h"

#include <math.h>
#include <stdlib.h>

enum { WARM_UP = 120, FRAMES = 200, SIZE = 128 };

/* Ways across 1920 x 1080 pixels, there and back */
typedef struct {
    double x, y, height, rate;
    float look[SIZE];
} walker;

static void draw_walkers(lt_rng *r, walker w[BENCH_TRACKS])
{
    for (int i = 0; i < BENCH_TRACKS; i++) {
        w[i].x = lt_rng_range(r, 200, 1700);
        w[i].y = lt_rng_range(r, 300, 500);
        w[i].height = lt_rng_range(r, 150, 350);
        w[i].rate = lt_rng_range(r, 0.005, 0.02);
        for (int k = 0; k < SIZE; k++)
            w[i].look[k] = (float)lt_rng_normal(r);
    }
}

static void see(lt_rng *r, const walker w[BENCH_TRACKS], int frame, track_detection *found, float (*look)[SIZE])
{
    for (int i = 0; i < BENCH_TRACKS; i++) {
        const double x = w[i].x + 150 * sin(w[i].rate * frame), half = w[i].height / 5;
        const double box[4] = { x - half, w[i].y, x + half, w[i].y + w[i].height };

        for (int k = 0; k < SIZE; k++)
            look[i][k] = w[i].look[k] + 0.2f * (float)lt_rng_normal(r);
        found[i] = (track_detection){ .score = 0.8f, .embedding = look[i] };
        for (int c = 0; c < 4; c++)
            found[i].box[c] = (float)(box[c] + 0.01 * w[i].height * lt_rng_normal(r));
    }
}

static lt_status measure(tracker *t, double ms[FRAMES], int *tracks)
{
    static float look[BENCH_TRACKS][SIZE];
    walker w[BENCH_TRACKS];
    track_detection found[BENCH_TRACKS];
    lt_rng r = lt_rng_make(1, 0);
    lt_status st = LT_OK;

    draw_walkers(&r, w);
    for (int f = -WARM_UP; f < FRAMES && !st; f++) {
        const tracked_box *box;
        double start;

        see(&r, w, f, found, look);
        start = lt_clock();
        st = tracker_step(t, f / tracker_defaults.fps, found, BENCH_TRACKS, &box, tracks);
        if (f >= 0)
            ms[f] = 1e3 * (lt_clock() - start);
    }
    return st;
}

lt_status bench_tracks(double *median_ms, int *tracks)
{
    double ms[FRAMES];
    tracker *t;
    lt_status st = tracker_new(&tracker_defaults, &t);

    if (st)
        return st;
    st = measure(t, ms, tracks);
    tracker_free(t);
    qsort(ms, FRAMES, sizeof(*ms), lt_ascending);
    *median_ms = ms[FRAMES / 2];
    return st;
}
