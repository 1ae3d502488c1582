/* SPDX-License-Identifier: Apache-2.0 */
/* Whole runs: the same bits on any number of threads and after any stop, and what happens when things go wrong. */
#include "libtensor/base/parallel.h"
#include "libtensor/io/array/safetensors.h"
#include "libtensor/io/file.h"
#include "tasks/tasks.h"
#include "tests/train/tree.h"
#include "train/trainer.h"

#include <math.h>
#include <signal.h>
#include <sys/resource.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

/* ---- running ------------------------------------------------------------------------------------------ */

static const char *set[16];
static int n_set;

static void with(const char *assignment)
{
    set[n_set++] = assignment;
}

static train_options options(const char *out)
{
    return (train_options){ .tasks = tasks, .config = tree_at("tiny.json"), .set = set, .n_set = n_set,
                            .out = tree_at(out), .quiet = true };
}

/* On one thread: the tests are forked off, and threads of OpenMP do not survive that. */
static void setup(void)
{
    lt_set_threads(1);
    tree_make(true);
}

static void begin(void)
{
    lt_set_threads(1);
    n_set = 0;
    with(lt_arena_printf(tree_arena, "data.dir=\"%s\"", scratch_folder));
}

static void run_ok(const train_options *o)
{
    check_ok(train_run(o, NULL));
}

static void expect(const train_options *o, lt_status want, const char *words)
{
    const lt_status st = train_run(o, NULL);

    ck_assert_msg(st == want, "status %d: %s", (int)st, lt_last_error());
    ck_assert_msg(strstr(lt_last_error(), words) != NULL, "\"%s\" does not say \"%s\"", lt_last_error(), words);
}

static const char *file_of(const char *run, const char *name)
{
    return lt_arena_printf(tree_arena, "%s/%s/%s", scratch_folder, run, name);
}

static const char *last_of(const char *run)
{
    return file_of(run, "checkpoints/last.safetensors");
}

static void read_back(const char *path, uint8_t **bytes, size_t *n)
{
    check_ok(lt_read_file(tree_arena, tree_at(path), LT_FILE_MAX, bytes, n));
}

static int lines_of(const char *path)
{
    uint8_t *bytes;
    size_t n;
    int lines = 0;

    read_back(path, &bytes, &n);
    for (size_t i = 0; i < n; i++)
        lines += bytes[i] == '\n';
    return lines;
}

static int lines_with(const char *path, const char *words)
{
    uint8_t *bytes;
    size_t n;
    int lines = 0;

    read_back(path, &bytes, &n);
    for (const char *at = (const char *)bytes; (at = strstr(at, words)); at++)
        lines++;
    return lines;
}

/* ---- the same bits ------------------------------------------------------------------------------------ */

START_TEST(threads_do_not_matter)
{
    with("optim.steps=50");
    with("data.background=0.5");
    with("data.threads=3");
    for (int threads = 1; threads <= 4; threads++) {
        const char *out = lt_arena_printf(tree_arena, "threads%d", threads);
        const train_options o = options(out);

        lt_set_threads(threads);
        run_ok(&o);
        same_files(last_of("threads1"), last_of(out));
    }
    ck_assert_int_eq(lines_of("threads1/log.jsonl"), 50);
}
END_TEST

/* A larger model's plan puts more into the same places of its memory. */
START_TEST(nor_do_they_for_what_comes_with_palmar)
{
    static const char *const name[] = { "hocat", "unified" };
    const char *root = getenv("srcdir");
    const char *config = lt_arena_printf(tree_arena, "%s/models/%s/configs/tiny.json", root ? root : ".", name[_i]);

    with("optim.steps=2");
    for (int threads = 1; threads <= 3; threads++) {
        const char *out = lt_arena_printf(tree_arena, "%s%d", name[_i], threads);
        train_options o = options(out);

        o.config = config;
        lt_set_threads(threads);
        run_ok(&o);
        same_files(last_of(lt_arena_printf(tree_arena, "%s1", name[_i])), last_of(out));
    }
}
END_TEST

/* Stop a run before a step, as the user would. */
typedef struct {
    int64_t step;
    int signal;
} stop_at;

static void raise_signal(void *ctx, int64_t step, lt_params *params)
{
    const stop_at *s = ctx;

    (void)params;
    if (step == s->step)
        raise(s->signal);
}

static const char *const configs[] = { "tiny.json", "unified.json" };

/* With shards, an average, new backgrounds, dropout, validation at epochs and a partial last batch, stopped at each
 * step. */
START_TEST(resume_is_exact)
{
    train_options o;

    const char *whole = lt_arena_printf(tree_arena, "whole%d", _i), *config = tree_at(configs[_i]);

    with("optim.shards=2");
    with("data.background=0.5");
    with("optim.ema_decay=0.9");
    with("train.validate_every=1");
    with("optim.steps=9");
    o = options(whole);
    o.config = config;
    run_ok(&o);
    for (int64_t step = 1; step < 9; step++) {
        const char *out = lt_arena_printf(tree_arena, "stopped%d.%d", _i, (int)step);
        stop_at at = { step, step % 2 ? SIGTERM : SIGINT };
        train_result r;

        o = options(out);
        o.config = config;
        o.before_step = raise_signal;
        o.ctx = &at;
        ck_assert_int_eq(train_run(&o, &r), LT_ESTOPPED);
        ck_assert_int_eq(r.step, step);
        ck_assert_int_eq(r.signal, at.signal);
        o.before_step = NULL;
        o.resume = "";
        o.config = step % 2 ? NULL : o.config;
        run_ok(&o);
        same_files(last_of(whole), last_of(out));
        same_files(file_of(whole, "metrics.csv"), file_of(out, "metrics.csv"));
        same_files(file_of(whole, "checkpoints/best.safetensors"), file_of(out, "checkpoints/best.safetensors"));
        ck_assert_int_eq(lines_of(lt_arena_printf(tree_arena, "%s/log.jsonl", out)), 9 + 3);
    }
}
END_TEST

static void hide_pictures(void *ctx, int64_t step, lt_params *params)
{
    (void)params;
    if (step == *(const int64_t *)ctx)
        rename(tree_at("train/SYN1MB10/rgb"), tree_at("train/SYN1MB10/gone"));
}

/* Data that go while a run is on end it, and cost no step that was taken. */
START_TEST(lost_data)
{
    int64_t step = 3;
    train_options o;

    with("optim.steps=40");
    with("data.tolerate=0");
    o = options("unbroken");
    run_ok(&o);
    o = options("broken");
    o.before_step = hide_pictures;
    o.ctx = &step;
    expect(&o, LT_EIO, "train/SYN1MB10/rgb");
    ck_assert(exists(last_of("broken")));
    rename(tree_at("train/SYN1MB10/gone"), tree_at("train/SYN1MB10/rgb"));
    o.before_step = NULL;
    o.config = NULL;
    o.resume = "";
    run_ok(&o);
    same_files(last_of("unbroken"), last_of("broken"));
}
END_TEST

START_TEST(usr1_saves_and_goes_on)
{
    stop_at at = { 2, SIGUSR1 };
    train_options o;

    with("optim.steps=4");
    o = options("usr1");
    o.before_step = raise_signal;
    o.ctx = &at;
    run_ok(&o);
    ck_assert(exists(tree_at("usr1/checkpoints/step-000002.safetensors")));
    ck_assert(exists(tree_at("usr1/checkpoints/step-000004.safetensors")));
}
END_TEST

START_TEST(shards_repeat)
{
    train_options o;

    with("optim.steps=6");
    with("optim.shards=4");
    with("optim.kind=adamw");
    with("optim.clip_norm=1");
    o = options("shards4a");
    run_ok(&o);
    for (int threads = 2; threads <= 4; threads++) {            /* half a shard a thread; with 3, half after half */
        const char *out = lt_arena_printf(tree_arena, "shards4.%d", threads);

        lt_set_threads(threads);
        o = options(out);
        run_ok(&o);
        same_files(last_of("shards4a"), last_of(out));
    }
}
END_TEST

/* ---- numbers that are none ---------------------------------------------------------------------------- */

typedef struct {
    int64_t from, to;               /* steps that see a weight that is not a number */
    float *weight, kept;
    float before[2][64];            /* other weights, as they were when it began, and after */
    lt_param *other;
} poison;

static void spoil(void *ctx, int64_t step, lt_params *params)
{
    poison *p = ctx;

    p->other = lt_params_find(params, "trunk.conv1.weight");
    p->weight = lt_params_first(params)->next->data;
    if (step == p->from) {
        p->kept = p->weight[0];
        memcpy(p->before[0], p->other->data, sizeof(p->before[0]));
        p->weight[0] = NAN;
    }
    if (step == p->to) {
        memcpy(p->before[1], p->other->data, sizeof(p->before[1]));
        p->weight[0] = p->kept;
    }
}

START_TEST(bad_steps_change_nothing)
{
    poison p = { .from = 3, .to = 5 };
    train_result r;
    train_options o;

    with("optim.steps=7");
    o = options("bad");
    o.before_step = spoil;
    o.ctx = &p;
    o.progress = tmpfile();
    check_ok(train_run(&o, &r));
    ck_assert_int_eq(r.skipped, 2);
    ck_assert_int_eq(r.step, 7);
    ck_assert(isfinite(r.loss));
    ck_assert_mem_eq(p.before[0], p.before[1], sizeof(p.before[0]));
    fclose(o.progress);
}
END_TEST

START_TEST(too_many_bad_steps)
{
    poison p = { .from = 4, .to = 100 };
    train_options o;

    with("optim.steps=20");
    with("train.checkpoint_steps=3");
    with("train.max_bad_steps=3");
    o = options("fatal");
    o.before_step = spoil;
    o.ctx = &p;
    o.progress = tmpfile();
    expect(&o, LT_ENUMERIC, "step 6: 3 steps in a row without a finite gradient; the first bad tensor is ");
    ck_assert(!exists(tree_at("fatal/checkpoints/step-000006.safetensors")));
    ck_assert(exists(tree_at("fatal/checkpoints/step-000003.safetensors")));
    ck_assert_int_eq(lines_of("fatal/log.jsonl"), 6);
    ck_assert_int_eq(lines_with("fatal/stderr.log", "  model        hocat"), 1);
    ck_assert_int_eq(lines_with("fatal/stderr.log", "  warning: step "), 3);
    ck_assert_int_eq(lines_with("fatal/stderr.log", "  ended: step 6: 3 steps in a row"), 1);
    fclose(o.progress);
}
END_TEST

/* ---- files that fail ---------------------------------------------------------------------------------- */

static void limit_files(void *ctx, int64_t step, lt_params *params)
{
    (void)ctx;
    (void)params;
    if (step == 3)
        setrlimit(RLIMIT_FSIZE, &(struct rlimit){ 200000, RLIM_INFINITY });
}

static int entries(const char *folder)
{
    char command[256];
    int n = -1;
    FILE *f;

    snprintf(command, sizeof(command), "ls %s | wc -l", tree_at(folder));
    f = popen(command, "r");
    ck_assert_int_eq(fscanf(f, "%d", &n), 1);
    pclose(f);
    return n;
}

START_TEST(disk_full)
{
    train_options o;

    signal(SIGXFSZ, SIG_IGN);
    with("optim.steps=6");
    with("train.checkpoint_steps=2");
    o = options("full");
    o.before_step = limit_files;
    expect(&o, LT_ENOSPC, "step-000004.safetensors");
    setrlimit(RLIMIT_FSIZE, &(struct rlimit){ RLIM_INFINITY, RLIM_INFINITY });
    ck_assert_int_eq(entries("full/checkpoints"), 2);           /* step 2 and last */
    o.before_step = NULL;
    o.resume = "";
    run_ok(&o);
    o = options("roomy");
    run_ok(&o);
    same_files(last_of("full"), last_of("roomy"));
}
END_TEST

static void damage(const char *path, size_t at)
{
    uint8_t *bytes;
    size_t n;

    read_back(path, &bytes, &n);
    bytes[at < n ? at : n - 1] ^= 16;
    unlink(tree_at(path));                      /* last is a name of the same file */
    check_ok(lt_write_file(tree_at(path), bytes, n));
}

START_TEST(damaged_newest)
{
    train_options o;

    with("optim.steps=6");
    with("train.checkpoint_steps=2");
    o = options("damaged");
    run_ok(&o);
    damage("damaged/checkpoints/step-000006.safetensors", SIZE_MAX);
    damage("damaged/checkpoints/step-000004.safetensors", 300000);
    o.resume = "";
    o.progress = tmpfile();
    run_ok(&o);
    same_files(last_of("damaged"), tree_at("damaged/checkpoints/step-000006.safetensors"));
    ck_assert_int_eq(lines_of("damaged/log.jsonl"), 6);
    o.resume = tree_at("damaged/checkpoints/step-000002.safetensors");
    damage("damaged/checkpoints/step-000002.safetensors", 100000);
    expect(&o, LT_EFORMAT, "is damaged: its check sum is ");
    fclose(o.progress);
}
END_TEST

/* What is saved after going back behind damaged files stays, though they have higher numbers. */
START_TEST(damaged_newest_and_one_kept)
{
    stop_at at = { 5, SIGTERM };
    train_options o;

    with("optim.steps=6");
    with("train.checkpoint_steps=2");
    o = options("one");
    run_ok(&o);
    damage("one/checkpoints/step-000006.safetensors", 300000);
    with("train.keep=1");
    o = options("one");
    o.resume = "";
    o.progress = tmpfile();
    o.before_step = raise_signal;
    o.ctx = &at;
    expect(&o, LT_ESTOPPED, "at step 5");
    ck_assert(exists(tree_at("one/checkpoints/step-000005.safetensors")));
    o.before_step = NULL;
    run_ok(&o);
    same_files(last_of("one"), tree_at("one/checkpoints/step-000006.safetensors"));
    fclose(o.progress);
}
END_TEST

/* Killed between a checkpoint's names, a run gives it the missing one when it goes on. */
START_TEST(best_is_named_again)
{
    train_options o;

    with("optim.steps=3");
    with("train.validate_steps=3");
    with("train.validate_samples=4");
    o = options("best");
    run_ok(&o);
    ck_assert_int_eq(unlink(tree_at("best/checkpoints/best.safetensors")), 0);
    with("optim.steps=4");
    o = options("best");
    o.resume = "";
    run_ok(&o);
    same_files(tree_at("best/checkpoints/best.safetensors"), tree_at("best/checkpoints/step-000003.safetensors"));
}
END_TEST

START_TEST(of_another_model)
{
    train_options o;

    with("optim.steps=1");
    o = options("mine");
    run_ok(&o);
    o = options("other");
    o.resume = last_of("mine");
    with("model.variant=base");
    o.n_set = n_set;
    expect(&o, LT_EINVAL, "is of model hocat (full), not of hocat (base)");
    set[n_set - 1] = "model.width=16";
    expect(&o, LT_EINVAL, "the model's \"trunk.conv1.weight\" is (16, 3, 7, 7)");
    set[n_set - 1] = "train.seed=4";
    expect(&o, LT_EINVAL, "train.seed: 4, but the run to resume has 3");
    set[n_set - 1] = "train.seed=3";
    o.resume = NULL;
    o.out = tree_at("mine");
    expect(&o, LT_EINVAL, "holds a run already");
    o.out = tree_at("nothing");
    o.resume = "";
    expect(&o, LT_EINVAL, "no checkpoint to resume from; begin again without --resume");
    o = options("mine");
    o.resume = "";
    with("optim.batch=2");
    o.n_set = n_set;
    expect(&o, LT_EINVAL, "optim.batch: 2, but the run to resume has 4");
}
END_TEST

/* Stopped before its first checkpoint, a run is begun again in its folder. */
START_TEST(before_the_first_checkpoint)
{
    train_options o;

    with("optim.steps=1");
    o = options("killed");
    run_ok(&o);
    ck_assert_int_eq(unlink(last_of("killed")), 0);
    ck_assert_int_eq(unlink(tree_at("killed/checkpoints/step-000001.safetensors")), 0);
    ck_assert(exists(tree_at("killed/log.jsonl")));
    run_ok(&o);
    ck_assert(exists(tree_at("killed/checkpoints/step-000001.safetensors")));
}
END_TEST

/* Nothing is written, and nothing goes on, where it would be mixed up with something else. */
START_TEST(resume_refused)
{
    train_options o;
    int fd;

    with("optim.steps=4");
    with("train.checkpoint_steps=1");
    o = options("refused");
    run_ok(&o);
    o.resume = tree_at("refused/checkpoints/step-000003.safetensors");
    expect(&o, LT_EINVAL, "of step 3, but ");
    expect(&o, LT_EINVAL, "step-000004.safetensors is there already; choose another --out, or remove what came after");
    o.out = tree_at("branch");
    run_ok(&o);
    same_files(last_of("refused"), last_of("branch"));
    o.out = tree_at("refused");
    o.resume = "";
    with("optim.kind=sgd");
    o.n_set = n_set;
    expect(&o, LT_EINVAL, "optim.kind: sgd, but the run to resume has adam");
    o.n_set = n_set - 1;
    fd = open(o.out, O_RDONLY | O_DIRECTORY);
    ck_assert_int_eq(flock(fd, LOCK_EX), 0);
    expect(&o, LT_EINVAL, "another palmar train is at work there");
    close(fd);
    run_ok(&o);
}
END_TEST

/* ---- initial weights, dry runs, validation without truth ------------------------------------------------ */

START_TEST(initial_weights)
{
    float w[8 * 3 * 7 * 7] = { 0.5f };
    lt_named_array e[2] = {
        { "conv1.weight", lt_array_make(LT_ELEM_F4, 4, (int64_t[]){ 8, 3, 7, 7 }, w) },
        { "fc.weight", lt_array_make(LT_ELEM_F4, 1, (int64_t[]){ 8 }, w) },
    };
    train_options o = options("init");
    char text[4096] = "";

    check_ok(lt_safetensors_write(tree_at("init.safetensors"), e, 2, NULL, 0));
    o.init = tree_at("init.safetensors");
    o.dry_run = true;
    o.quiet = false;
    o.progress = tmpfile();
    run_ok(&o);
    rewind(o.progress);
    ck_assert_uint_gt(fread(text, 1, sizeof(text) - 1, o.progress), 0);
    ck_assert_ptr_nonnull(strstr(text, "safetensors, names of torchvision and palmar; 1 parameters loaded"));
    ck_assert_ptr_nonnull(strstr(text, ": trunk.bn1.weight, trunk.bn1.bias, "));
    ck_assert_ptr_nonnull(strstr(text, "left over  1: fc.weight"));
    ck_assert_ptr_nonnull(strstr(text, "HO3D v3 (synthetic), "));
    ck_assert(!exists(tree_at("init")));                                  /* a dry run leaves nothing */
    e[0].array.shape[0] = 4;
    check_ok(lt_safetensors_write(tree_at("init.safetensors"), e, 2, NULL, 0));
    expect(&o, LT_EINVAL, "\"conv1.weight\" is (4, 3, 7, 7), the model's \"trunk.conv1.weight\" is (8, 3, 7, 7)");
    fclose(o.progress);
}
END_TEST

static void keep_validation(void *ctx, const train_validation *v)
{
    *(train_validation *)ctx = *v;
}

START_TEST(validation_without_truth)
{
    train_validation v = { 0 };
    train_options o;

    rename(tree_at("evaluation_xyz.json"), tree_at("hidden.json"));
    with("train.validate_steps=3");
    with("train.validate_samples=4");
    with("optim.steps=3");
    o = options("held");
    o.validated = keep_validation;
    o.ctx = &v;
    run_ok(&o);
    ck_assert_int_eq(v.samples, 4);
    ck_assert_msg(isfinite(v.loss) && v.value[0] > 0 && v.value[1] > 0, "%g %g %g", v.loss, v.value[0],
                  v.value[1]);
    ck_assert(exists(tree_at("held/checkpoints/best.safetensors")));
    ck_assert_int_eq(lines_of("held/metrics.csv"), 2);
    set[n_set - 2] = "train.validate_samples=14";
    o = options("none");
    expect(&o, LT_EINVAL, "holding back 14 of 14 training samples leaves none");
    rename(tree_at("hidden.json"), tree_at("evaluation_xyz.json"));
}
END_TEST

START_TEST(background_without_masks)
{
    train_options o = options("masks");

    rename(tree_at("train/SYN1MB10/seg"), tree_at("train/SYN1MB10/hidden"));
    with("data.background=0.5");
    with("optim.steps=1");
    o.n_set = n_set;
    expect(&o, LT_EINVAL, lt_arena_printf(tree_arena, "data.background: SYN1MB10/0000 has no mask of hand and object, "
                                          "which HO3D keeps in %s/train/SEQUENCE/seg", scratch_folder));
    with("data.augment=false");
    o.n_set = n_set;
    run_ok(&o);
    rename(tree_at("train/SYN1MB10/hidden"), tree_at("train/SYN1MB10/seg"));
}
END_TEST

/* Threads that wait must not burn the cores of those that work: there may be more of them than cores. */
static void wait_passively(char **argv)
{
    if (getenv("OMP_WAIT_POLICY"))
        return;
    setenv("OMP_WAIT_POLICY", "passive", 1);
    execv("/proc/self/exe", argv);
}

static void add_tests(TCase *c)
{
    tcase_set_timeout(c, 0);
    tcase_add_unchecked_fixture(c, setup, tree_remove);
    tcase_add_checked_fixture(c, begin, NULL);
    tcase_add_loop_test(c, resume_is_exact, 0, (int)LT_COUNT(configs));
    tcase_add_test(c, lost_data);
    tcase_add_test(c, usr1_saves_and_goes_on);
    tcase_add_test(c, shards_repeat);
    tcase_add_test(c, bad_steps_change_nothing);
    tcase_add_test(c, too_many_bad_steps);
    tcase_add_test(c, disk_full);
    tcase_add_test(c, damaged_newest);
    tcase_add_test(c, damaged_newest_and_one_kept);
    tcase_add_test(c, best_is_named_again);
    tcase_add_test(c, of_another_model);
    tcase_add_test(c, before_the_first_checkpoint);
    tcase_add_test(c, resume_refused);
    tcase_add_test(c, initial_weights);
    tcase_add_test(c, validation_without_truth);
    tcase_add_test(c, background_without_masks);
    tcase_add_test(c, threads_do_not_matter);
    tcase_add_loop_test(c, nor_do_they_for_what_comes_with_palmar, 0, 2);
}

int main(int argc, char **argv)
{
    (void)argc;
    wait_passively(argv);
    return run_suite("trainer", add_tests);
}
