/* SPDX-License-Identifier: Apache-2.0 */
/* A task with all that hurts, on the trainer: the same bits on any number of threads and ranks, and after any stop. */
#include "libtensor/base/parallel.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/atomic_file.h"
#include "libtensor/io/file.h"
#include "tests/scratch.h"
#include "tests/tasks/blobs/blobs.h"
#include "train/trainer.h"

#include <pthread.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

static const task *const tasks[] = { &blobs_task, NULL };

static void setup(void)
{
    static const char config[] = "{ \"model\": { \"name\": \"blobs\" }, \"train\": { \"validate_steps\": 30, "
        "\"validate_every\": 0, \"checkpoint_minutes\": 0 }, \"data\": { \"threads\": 2 } }";

    open_scratch();
    check_ok(lt_write_file(at("blobs.json"), config, sizeof(config) - 1));
}

static train_options options(const char *out)
{
    return (train_options){ .tasks = tasks, .config = at("blobs.json"), .out = at(out), .quiet = true };
}

START_TEST(threads_do_not_matter)
{
    for (int threads = 1; threads <= 4; threads++) {
        const char *out = lt_arena_printf(arena, "threads%d", threads);
        const train_options o = options(out);

        lt_set_threads(threads);
        check_ok(train_run(&o, NULL));
        same_end("threads1", out);
    }
}
END_TEST

static void raise_at(void *ctx, int64_t step, lt_params *params)
{
    (void)params;
    if (step == *(const int64_t *)ctx)
        raise(SIGTERM);
}

/* Before a growth, at one, behind it, where a phase begins, and where both capacity and phase have changed */
START_TEST(stops_do_not_matter)
{
    static const int64_t stops[] = { 19, 20, 21, 40, 41, 50, 51, 61, 100, 119 };
    train_options o = options("whole");
    int64_t stop;

    check_ok(train_run(&o, NULL));
    o.out = at("stopped");
    o.before_step = raise_at;
    o.ctx = &stop;
    for (size_t i = 0; i < LT_COUNT(stops); i++) {
        stop = stops[i];
        ck_assert_int_eq(train_run(&o, NULL), LT_ESTOPPED);
        o.config = NULL;
        o.resume = "";
    }
    stop = -1;
    check_ok(train_run(&o, NULL));
    same_end("whole", "stopped");
}
END_TEST

/* ---- several ranks, each a thread of this process ------------------------------------------------------------- */

enum { RANKS = 4 };

static int line[RANKS][RANKS];          /* a rank's end of its line to another */

typedef struct {
    train_ranks ranks;
    train_options options;
    lt_status status;
    char error[512];
} rank_thread;

static lt_status say(void *ctx, int to, const void *data, size_t bytes)
{
    const rank_thread *me = ctx;

    for (size_t done = 0; done < bytes;) {
        const ssize_t n = send(line[me->ranks.rank][to], (const char *)data + done, bytes - done, MSG_NOSIGNAL);

        if (n <= 0)
            return lt_error(LT_EIO, "rank %d has left", to);
        done += (size_t)n;
    }
    return LT_OK;
}

static lt_status hear(void *ctx, int from, void *data, size_t bytes)
{
    const rank_thread *me = ctx;

    for (size_t done = 0; done < bytes;) {
        const ssize_t n = recv(line[me->ranks.rank][from], (char *)data + done, bytes - done, 0);

        if (n <= 0)
            return lt_error(LT_EIO, "rank %d has left", from);
        done += (size_t)n;
    }
    return LT_OK;
}

static void hang_up(void *ctx)
{
    const rank_thread *me = ctx;

    for (int k = 0; k < me->ranks.size; k++)
        if (k != me->ranks.rank)
            shutdown(line[me->ranks.rank][k], SHUT_RDWR);
}

static void *run_rank(void *arg)
{
    rank_thread *me = arg;

    me->status = train_run(&me->options, NULL);
    snprintf(me->error, sizeof(me->error), "%s", me->status ? lt_last_error() : "");
    return NULL;
}

/* Train with so many ranks; change, or NULL, makes the options of one of them other than the rest's. */
static void run_ranks(const train_options *o, int size, void (*change)(rank_thread *), rank_thread thread[RANKS])
{
    pthread_t id[RANKS];

    for (int a = 0; a < size; a++)
        for (int b = a + 1; b < size; b++) {
            int pair[2];

            ck_assert_int_eq(socketpair(AF_UNIX, SOCK_STREAM, 0, pair), 0);
            line[a][b] = pair[0];
            line[b][a] = pair[1];
        }
    for (int k = 0; k < size; k++) {
        thread[k] = (rank_thread){
            .ranks = { .rank = k, .size = size, .send = say, .receive = hear, .fail = hang_up, .ctx = &thread[k] },
            .options = *o,
        };
        thread[k].options.ranks = &thread[k].ranks;
    }
    if (change)
        change(&thread[size - 1]);
    for (int k = 0; k < size; k++)
        ck_assert_int_eq(pthread_create(&id[k], NULL, run_rank, &thread[k]), 0);
    for (int k = 0; k < size; k++)
        pthread_join(id[k], NULL);
    for (int a = 0; a < size; a++)
        for (int b = 0; b < size; b++)
            if (a != b)
                close(line[a][b]);
}

START_TEST(ranks_do_not_matter)
{
    rank_thread thread[RANKS];

    for (int size = 1; size <= 3; size++) {
        const char *out = lt_arena_printf(arena, "ranks%d", size);
        const train_options o = options(out);

        if (size == 1)
            check_ok(train_run(&o, NULL));
        else
            run_ranks(&o, size, NULL, thread);
        for (int k = 0; size > 1 && k < size; k++)
            ck_assert_msg(thread[k].status == LT_OK, "rank %d: %s", k, thread[k].error);
        same_end("ranks1", out);
    }
}
END_TEST

/* The signal comes to one of them. */
static void raise_there(rank_thread *last)
{
    last->options.before_step = raise_at;
}

/* Stopped on two ranks behind a growth, gone on with on three, and on one */
START_TEST(ranks_come_and_go)
{
    int64_t stop = 41;
    rank_thread thread[RANKS];
    train_options o = options("whole");

    check_ok(train_run(&o, NULL));
    o.out = at("moved");
    o.ctx = &stop;
    run_ranks(&o, 2, raise_there, thread);
    for (int k = 0; k < 2; k++)
        ck_assert_msg(thread[k].status == LT_ESTOPPED, "rank %d: %s", k, thread[k].error);
    o.config = NULL;
    o.resume = "";
    stop = 75;
    run_ranks(&o, 3, raise_there, thread);
    for (int k = 0; k < 3; k++)
        ck_assert_msg(thread[k].status == LT_ESTOPPED, "rank %d: %s", k, thread[k].error);
    check_ok(train_run(&o, NULL));
    same_end("whole", "moved");
}
END_TEST

static void other_seed(rank_thread *last)
{
    static const char *const set[] = { "train.seed=5" };

    last->options.set = set;
    last->options.n_set = 1;
}

/* One that trains something else is found before anything is made; one that fails takes the others along. */
START_TEST(ranks_agree)
{
    const train_options o = options("apart");
    rank_thread thread[RANKS];

    run_ranks(&o, 3, other_seed, thread);
    ck_assert_msg(strstr(thread[2].error, "rank 2 on ") && strstr(thread[2].error, " has a configuration of CRC-32 "),
                  "%s", thread[2].error);
    for (int k = 0; k < 2; k++)
        ck_assert_msg(thread[k].status == LT_EIO, "rank %d: %s", k, thread[k].error);
    run_ranks(&o, 4, NULL, thread);
    ck_assert_str_eq(thread[3].error,
                     "4 ranks, and a batch of phase fine has 3 shards: some ranks would have nothing to do");
}
END_TEST

/* ---- what a run takes ------------------------------------------------------------------------------------------ */

static size_t too_much(const train_config *c, const char **less)
{
    (void)c;
    *less = "data.cache_mb";
    return (size_t)1 << 50;
}

/* A dry run knows all phases, and makes nothing; what does not fit is refused before the task is opened. */
START_TEST(foreseen)
{
    task hungry = blobs_task;
    const task *const only[] = { &hungry, NULL };
    train_options o = options("foreseen");
    train_result r;

    o.dry_run = true;
    check_ok(train_run(&o, &r));
    ck_assert_int_eq(r.steps, 120);
    ck_assert(r.eta_seconds > 0 && r.bytes > 0 && r.disk_bytes > 0);
    hungry.bytes = too_much;
    hungry.open = NULL;
    o.tasks = only;
    ck_assert_int_eq(train_run(&o, NULL), LT_ENOMEM);
    ck_assert_msg(strstr(lt_last_error(), "blobs.json: the run takes 1125899906.8 MB of memory beside its network, "
                         "and ")
                  && strstr(lt_last_error(), " are free; a smaller data.cache_mb takes less"), "%s", lt_last_error());
    ck_assert(!lt_is_folder(at("foreseen")));
}
END_TEST

START_TEST(blobs_are_found)
{
    const train_options o = options("run");
    train_result r;
    lt_safetensors f;
    uint8_t *csv;
    size_t n;

    check_ok(train_run(&o, &r));
    ck_assert_int_eq(r.step, 120);
    ck_assert_int_eq(r.skipped, 0);
    ck_assert_msg(r.best > 0.4 && r.best <= 1, "average precision %g", r.best);
    check_ok(lt_read_file(arena, at("run/metrics.csv"), LT_FILE_MAX, &csv, &n));
    ck_assert_msg(n > 50 && !memcmp(csv, "step,epoch,samples,blobs_ap,loss,picture\n30,", 43), "%.60s", (char *)csv);
    check_ok(lt_safetensors_read(arena, last_of("run"), &f));
    ck_assert_int_eq(lt_safetensors_find(&f, "blobs.centre")->shape[0], 3 * 8);     /* it grew */
    ck_assert_int_eq(lt_safetensors_find(&f, "optim.m.blobs.centre")->shape[0], 3 * 8);
    ck_assert_int_eq(lt_safetensors_find(&f, "task.slope")->shape[0], 3 * 8);
}
END_TEST

static void add_tests(TCase *tc)
{
    tcase_set_timeout(tc, 0);
    tcase_add_checked_fixture(tc, setup, close_scratch);
    tcase_add_test(tc, threads_do_not_matter);
    tcase_add_test(tc, stops_do_not_matter);
    tcase_add_test(tc, ranks_do_not_matter);
    tcase_add_test(tc, ranks_come_and_go);
    tcase_add_test(tc, ranks_agree);
    tcase_add_test(tc, foreseen);
    tcase_add_test(tc, blobs_are_found);
}

int main(void)
{
    return run_suite("blobs", add_tests);
}
