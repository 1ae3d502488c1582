/* SPDX-License-Identifier: Apache-2.0 */
#include "eval/bench/frames.h"

#include "libtensor/base/clock.h"
#include "libtensor/base/order.h"
#include "libtensor/base/rng.h"
#include "models/action/skeleton.h"
#include "models/action/stream.h"

#include <stdlib.h>

enum { WARM_UP = 120, FRAMES = 400, MOST_FEATURES = 256 };

lt_status bench_frames(const model *m, double *median_ms)
{
    lt_real joint[3 * SKELETON_BODY], feature[MOST_FEATURES];
    double ms[FRAMES];
    lt_rng r = lt_rng_make(1, 0);
    action_stream *s;
    const lt_status st = action_stream_new(m, &s);

    if (st)
        return st;
    for (int k = -WARM_UP; k < FRAMES; k++) {
        double start;

        for (int i = 0; i < 3 * SKELETON_BODY; i++)
            joint[i] = (lt_real)lt_rng_uniform(&r);
        start = lt_clock();
        action_stream_body(s, joint, feature);
        if (k >= 0)
            ms[k] = 1e3 * (lt_clock() - start);
    }
    action_stream_free(s);
    qsort(ms, FRAMES, sizeof(*ms), lt_ascending);
    *median_ms = ms[FRAMES / 2];
    return LT_OK;
}
