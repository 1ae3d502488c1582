/* SPDX-License-Identifier: Apache-2.0 */
/* Every draw stands in a statement of its own, as C leaves the order of arguments open. */
#include "synth/workplace/clock.h"

#include "libtensor/base/rng.h"
#include "synth/workplace/script.h"

enum { CLOCK = 0x574b434b, STAMP = 0x574b5354 };

static const double JITTER = 0.005, LAG[2] = { 0.006, 0.011 }, LOSS[2] = { 0.01, 0.02 };

void workplace_clock_draw(uint64_t seed, int n, workplace_clock *out)
{
    lt_rng r = lt_rng_make(seed, CLOCK);
    const int late = n > 1 ? 1 + (int)lt_rng_below(&r, (uint32_t)n - 1) : -1;
    const double lag = lt_rng_range(&r, LAG[0], LAG[1]);

    *out = (workplace_clock){ .seed = seed, .n = n };
    for (int c = 0; c < n; c++) {
        out->lag[c] = c == late ? lag : 0;
        out->loss[c] = lt_rng_range(&r, LOSS[0], LOSS[1]);
    }
}

double workplace_time(int k)
{
    return (k + 1.0) / WORKPLACE_FPS;
}

bool workplace_stamp(const workplace_clock *clock, int c, int k, double *out)
{
    lt_rng r = lt_rng_make(clock->seed, lt_rng_mix(lt_rng_mix(STAMP, (uint64_t)c), (uint64_t)k));
    const bool kept = lt_rng_uniform(&r) >= clock->loss[c];

    *out = workplace_time(k) + clock->lag[c] + lt_rng_range(&r, -JITTER, JITTER);
    return kept;
}
