/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One team of threads, made when it is first needed. Between regions a worker spins for some 100 us, as the
 * next one mostly follows at once, then sleeps: waking takes 20 to 50 us. A region waits for nobody but workers
 * that have taken a task: where the CPUs are shared with others, one that gets no time holds nobody up. (OpenMP's
 * barriers wait for the whole team: with three busy processes on two cores nine tenths of the time went there.)
 *
 * Each thread begins with a part of the tasks that is always the same, and helps the others when it is done: what
 * it left in its cache in one region it often finds there in the next, and they share no counter until the end.
 */
#define _GNU_SOURCE
#include "libtensor/base/parallel.h"

#include "libtensor/base/clock.h"
#include "libtensor/base/cpu.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>

static const double SPIN_SECONDS = 100e-6;

enum { LOOKS = 32, MAX_WORKERS = 1023, LINE = 64 };

/* The region in one word: its number, whether it still takes workers, and how many are in it. */
#define REGION(number) ((uint64_t)(number) << 32)
#define NUMBER(state) ((uint32_t)((state) >> 32))
#define CLOSED ((uint64_t)1 << 31)
#define INSIDE(state) ((uint32_t)(state) & 0x7fffffffu)

/* Tasks [next, end) of a thread; alone in a line of the caches. */
typedef struct {
    _Alignas(LINE) _Atomic int64_t next;
    int64_t end;
} share;

static int n_threads;               /* 0: not asked yet */

static struct {
    pthread_mutex_t region;         /* held by the caller whose tasks are run */
    pthread_mutex_t lock;           /* for sleeping: */
    pthread_cond_t opened, emptied;
    atomic_int asleep;              /* workers waiting for opened */
    atomic_bool caller_waits;       /* for emptied */
    _Alignas(LINE) _Atomic uint64_t state;
    atomic_int team;                /* workers below this number take part */
    lt_task_fn fn;
    void *ctx;
    int n_workers;
    share share[MAX_WORKERS + 1];
} pool = {
    .region = PTHREAD_MUTEX_INITIALIZER, .lock = PTHREAD_MUTEX_INITIALIZER,
    .opened = PTHREAD_COND_INITIALIZER, .emptied = PTHREAD_COND_INITIALIZER, .state = CLOSED,
};

static _Thread_local int thread_index;
static _Thread_local bool in_task;

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
    return thread_index;
}

static void pause_a_little(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

/* A turn of a spinning loop; false when it has spun for long enough: turns cannot be counted instead, as a pause takes
 * 10 to 40 ns, and more on some CPUs. *end starts as 0. */
static bool spin(int turn, double *end)
{
    pause_a_little();
    if (turn % LOOKS)
        return true;
    if (*end == 0)
        *end = lt_clock() + SPIN_SECONDS;
    return lt_clock() < *end;
}

static void run_serially(int64_t n, lt_task_fn fn, void *ctx)
{
    const unsigned mode = lt_flush_denormals();

    for (int64_t i = 0; i < n; i++)
        fn(ctx, i);
    lt_restore_denormals(mode);
}

static void take_from(share *s)
{
    int64_t i;

    while (atomic_load(&s->next) < s->end && (i = atomic_fetch_add(&s->next, 1)) < s->end)
        pool.fn(pool.ctx, i);
}

/* One's own tasks, then those that the next threads have left. */
static void work(int team)
{
    const unsigned mode = lt_flush_denormals();

    in_task = true;
    for (int i = 0; i < team; i++)
        take_from(&pool.share[(thread_index + i) % team]);
    in_task = false;
    lt_restore_denormals(mode);
}

/* ---- workers ------------------------------------------------------------------------------------------ */

static bool is_new(uint64_t state, uint32_t seen)
{
    return NUMBER(state) != seen && !(state & CLOSED);
}

static uint64_t wait_for_region(uint32_t seen)
{
    double end = 0;
    uint64_t state;

    for (int i = 1; spin(i, &end); i++) {
        state = atomic_load(&pool.state);
        if (is_new(state, seen))
            return state;
    }
    pthread_mutex_lock(&pool.lock);
    atomic_fetch_add(&pool.asleep, 1);
    while (!is_new(state = atomic_load(&pool.state), seen))
        pthread_cond_wait(&pool.opened, &pool.lock);
    atomic_fetch_sub(&pool.asleep, 1);
    pthread_mutex_unlock(&pool.lock);
    return state;
}

/* Enter the region that state showed, unless it has closed since. */
static bool enter(uint64_t state)
{
    const uint32_t number = NUMBER(state);

    while (NUMBER(state) == number && !(state & CLOSED))
        if (atomic_compare_exchange_weak(&pool.state, &state, state + 1))
            return true;
    return false;
}

static void leave(void)
{
    const uint64_t state = atomic_fetch_sub(&pool.state, 1) - 1;

    if (!(state & CLOSED) || INSIDE(state) || !atomic_load(&pool.caller_waits))
        return;
    pthread_mutex_lock(&pool.lock);
    pthread_cond_signal(&pool.emptied);
    pthread_mutex_unlock(&pool.lock);
}

static void *worker(void *number)
{
    uint32_t seen = 0;

    thread_index = (int)(intptr_t)number;
    for (;;) {
        const uint64_t state = wait_for_region(seen);
        const int team = atomic_load(&pool.team);

        seen = NUMBER(state);
        if (thread_index < team && enter(state)) {
            work(team);
            leave();
        }
    }
    return NULL;
}

/* A child process has none of its parent's threads. */
static void after_fork(void)
{
    pthread_mutex_init(&pool.region, NULL);
    pthread_mutex_init(&pool.lock, NULL);
    pthread_cond_init(&pool.opened, NULL);
    pthread_cond_init(&pool.emptied, NULL);
    atomic_store(&pool.asleep, 0);
    atomic_store(&pool.state, CLOSED);
    pool.n_workers = 0;
}

/* Signals are the business of the threads that the program made. Where no more can be had, fewer do. */
static void hire(int wanted)
{
    static bool told;
    sigset_t all, before;
    pthread_t thread;

    if (pool.n_workers >= wanted)
        return;
    if (!told)
        told = pthread_atfork(NULL, NULL, after_fork) == 0;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    while (pool.n_workers < wanted
           && pthread_create(&thread, NULL, worker, (void *)(intptr_t)(pool.n_workers + 1)) == 0) {
        pthread_detach(thread);
        pool.n_workers++;
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

/* ---- regions ------------------------------------------------------------------------------------------ */

static void open_region(int64_t n, int team)
{
    const uint32_t number = NUMBER(atomic_load(&pool.state)) + 1;

    for (int i = 0; i < team; i++) {
        atomic_store_explicit(&pool.share[i].next, i * n / team, memory_order_relaxed);
        pool.share[i].end = (i + 1) * n / team;
    }
    atomic_store(&pool.state, REGION(number ? number : 1));
    if (atomic_load(&pool.asleep) == 0)
        return;
    pthread_mutex_lock(&pool.lock);
    pthread_cond_broadcast(&pool.opened);
    pthread_mutex_unlock(&pool.lock);
}

/* No task is left: let nobody in any more, and wait for those who are still at work. */
static void close_region(void)
{
    uint64_t state = atomic_fetch_or(&pool.state, CLOSED);
    double end = 0;

    for (int i = 1; INSIDE(state) && spin(i, &end); i++)
        state = atomic_load(&pool.state);
    if (INSIDE(state) == 0)
        return;
    pthread_mutex_lock(&pool.lock);
    atomic_store(&pool.caller_waits, true);
    while (INSIDE(atomic_load(&pool.state)))
        pthread_cond_wait(&pool.emptied, &pool.lock);
    atomic_store(&pool.caller_waits, false);
    pthread_mutex_unlock(&pool.lock);
}

void lt_parallel_for(int64_t n, lt_task_fn fn, void *ctx)
{
    const int team = (int)lt_min_i64(lt_min_i64(lt_threads(), n), MAX_WORKERS + 1);

    if (team <= 1 || in_task || pthread_mutex_trylock(&pool.region)) {
        run_serially(n, fn, ctx);
        return;
    }
    hire(team - 1);
    pool.fn = fn;
    pool.ctx = ctx;
    atomic_store(&pool.team, team);
    open_region(n, team);
    work(team);
    close_region();
    pthread_mutex_unlock(&pool.region);
}
