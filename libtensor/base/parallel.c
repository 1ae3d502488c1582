/* SPDX-License-Identifier: Apache-2.0 */
#define _GNU_SOURCE
#include "libtensor/base/parallel.h"

#include "libtensor/base/cpu.h"

#include <omp.h>
#include <sched.h>

static int n_threads;               /* 0: not asked yet */

static int cpus_allowed(void)
{
    cpu_set_t set;
    int n = 0;

    if (sched_getaffinity(0, sizeof(set), &set) == 0)
        n = CPU_COUNT(&set);
    return n > 0 ? n : 1;
}

void lt_set_threads(int n)
{
    n_threads = n < 1 ? cpus_allowed() : n;
}

int lt_threads(void)
{
    if (n_threads == 0)
        n_threads = cpus_allowed();
    return n_threads;
}

int lt_thread_index(void)
{
    return omp_get_thread_num();
}

static void run_serially(int64_t n, lt_task_fn fn, void *ctx)
{
    const unsigned mode = lt_flush_denormals();

    for (int64_t i = 0; i < n; i++)
        fn(ctx, i);
    lt_restore_denormals(mode);
}

void lt_parallel_for(int64_t n, lt_task_fn fn, void *ctx)
{
    const int team = (int)lt_min_i64(lt_threads(), n);

    if (team <= 1 || omp_in_parallel()) {
        run_serially(n, fn, ctx);
        return;
    }
#pragma omp parallel num_threads(team)
    {
        const unsigned mode = lt_flush_denormals();

#pragma omp for schedule(dynamic, 1)
        for (int64_t i = 0; i < n; i++)
            fn(ctx, i);
        lt_restore_denormals(mode);
    }
}
