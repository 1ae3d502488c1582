/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/base/clock.h"
#include "libtensor/base/parallel.h"
#include "libtensor/kernels/kernels.h"

enum { ROUNDS = 20000, MOST_THREADS = 1024 };

typedef struct { double end; double done[MOST_THREADS]; } reading;

static void spin(void *ctx, int64_t task)
{
    reading *r = ctx;
    lt_real sink[2] = { 1, 0 };
    double done = 0;

    while (lt_clock() < r->end)
        done += lt_k->fma_loop(ROUNDS, sink);
    r->done[task] = done;
}

double lt_fma_peak_gflops(double ms)
{
    const int n = (int)lt_min_i64(lt_threads(), MOST_THREADS);
    const double start = lt_clock();
    reading r = { .end = start + 1e-3 * ms };
    double total = 0;

    lt_parallel_for(n, spin, &r);
    for (int i = 0; i < n; i++)
        total += r.done[i];
    return 1e-9 * total / (lt_clock() - start);
}
