/* SPDX-License-Identifier: Apache-2.0 */
/* Whole runs: the same bits on any number of threads and after any stop, and what happens when things go wrong. */
#include "libtensor/base/parallel.h"
#include "libtensor/io/file.h"
#include "tests/train/tree.h"
#include "train/trainer.h"

#include <math.h>
#include <signal.h>
#include <sys/resource.h>
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
    return (train_options){ .config = tree_at("tiny.json"), .set = set, .n_set = n_set, .out = tree_at(out),
                            .quiet = true };
}

static void setup(void)
{
    tree_make(true);
}

static void begin(void)
{
    n_set = 0;
    with(lt_arena_printf(tree_arena, "data.dir=\"%s\"", tree_root));
}

static void run_ok(const train_options *o)
{
    tree_ok(train_run(o, NULL));
}

static void same_file(const char *a, const char *b)
{
    uint8_t *x, *y;
    size_t n, m;

    tree_ok(lt_read_file(tree_arena, tree_at(a), LT_FILE_MAX, &x, &n));
    tree_ok(lt_read_file(tree_arena, tree_at(b), LT_FILE_MAX, &y, &m));
    ck_assert_uint_eq(n, m);
    ck_assert_msg(memcmp(x, y, n) == 0, "%s and %s differ", a, b);
}


/* ---- the same bits ------------------------------------------------------------------------------------ */

START_TEST(threads_do_not_matter)
{
    with("optim.steps=50");
    for (int threads = 1; threads <= 4; threads++) {
        const train_options o = options(lt_arena_printf(tree_arena, "threads%d", threads));

        lt_set_threads(threads);
        run_ok(&o);
        if (threads > 1)
            same_file("threads1/checkpoints/last.safetensors",
                      lt_arena_printf(tree_arena, "threads%d/checkpoints/last.safetensors", threads));
    }
}
END_TEST

int main(void)
{
    Suite *s = suite_create("trainer");
    TCase *c = tcase_create("runs");
    SRunner *r;
    int failed;

    tcase_set_timeout(c, 0);
    tcase_add_unchecked_fixture(c, setup, tree_remove);
    tcase_add_checked_fixture(c, begin, NULL);
    tcase_add_test(c, threads_do_not_matter);
    suite_add_tcase(s, c);
    r = srunner_create(s);
    srunner_run_all(r, CK_NORMAL);
    failed = srunner_ntests_failed(r);
    srunner_free(r);
    return failed != 0;
}
