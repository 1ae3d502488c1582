/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The one door to threads. Work is cut by the problem, never by the number of threads, so results
 * have the same bits on 1 and on 64.
 */
#ifndef LT_BASE_PARALLEL_H
#define LT_BASE_PARALLEL_H

#include "libtensor/base/common.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef void (*lt_task_fn)(void *ctx, int64_t task);

/**
 * lt_parallel_for - call fn(ctx, i) once for every i in [0, n), on all threads, in any order
 *
 * Tasks must not write what another task reads or writes. A reduction writes one partial result per
 * task and the caller adds them in order afterwards. Returns when all tasks are done. Called from
 * inside a task it runs serially. n <= 1 runs in the caller. In tasks subnormal numbers count as zero
 * (lt_flush_denormals).
 */
LT_API void lt_parallel_for(int64_t n, lt_task_fn fn, void *ctx);

/* lt_set_threads - how many threads lt_parallel_for uses; below 1: the CPUs this process may use */
LT_API void lt_set_threads(int n);
LT_API int lt_threads(void);

/* lt_thread_index - which of [0, lt_threads()) runs this task; for scratch memory, never for results */
LT_API int lt_thread_index(void);

#ifdef __cplusplus
}
#endif
#endif
