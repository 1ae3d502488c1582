/* SPDX-License-Identifier: Apache-2.0 */
/* What the test programs share: their main, the answer of a call that can fail, and a folder to write in. */
#ifndef TESTS_SUITE_H
#define TESTS_SUITE_H

#include "libtensor/io/file.h"

#include <check.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Run a suite and free it; returns what main does. */
static inline int run_tests(Suite *suite)
{
    SRunner *runner = srunner_create(suite);
    int failed;

    srunner_run_all(runner, CK_ENV);
    failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed != 0;
}

/* The same for a suite of one test case, to which add_tests gives fixtures and a timeout too where they are needed. */
static inline int run_suite(const char *name, void (*add_tests)(TCase *))
{
    Suite *suite = suite_create(name);
    TCase *tc = tcase_create(name);

    add_tests(tc);
    suite_add_tcase(suite, tc);
    return run_tests(suite);
}

#define check_ok(call) \
    do { \
        const lt_status check_st = (call); \
        ck_assert_msg(check_st == LT_OK, "%s: %s", #call, lt_last_error()); \
    } while (0)

#define check_error(call, status, reason) \
    do { \
        ck_assert_int_eq((call), (status)); \
        ck_assert_msg(strstr(lt_last_error(), (reason)), "\"%s\" lacks \"%s\"", lt_last_error(), (reason)); \
    } while (0)

/* ---- files ------------------------------------------------------------------------------------------ */

static char scratch_folder[32];

/* A fixture's two halves: unchecked, all tests of the case share one folder; checked, each has its own. */
static inline void make_scratch_folder(void)
{
    strcpy(scratch_folder, "/tmp/palmar-test-XXXXXX");
    ck_assert_ptr_nonnull(mkdtemp(scratch_folder));
}

static inline void remove_scratch_folder(void)
{
    char command[64];

    snprintf(command, sizeof(command), "rm -r %s", scratch_folder);
    ck_assert_int_eq(system(command), 0);
}

/* A name in it, good for the next seven calls. */
static inline const char *in_folder(const char *name)
{
    static char paths[8][256];
    static int next;
    char *path = paths[next++ % 8];

    snprintf(path, sizeof(paths[0]), "%s/%s", scratch_folder, name);
    return path;
}

static inline void put_file(const char *path, const void *bytes, size_t n)
{
    FILE *f = fopen(path, "wb");

    ck_assert_ptr_nonnull(f);
    ck_assert_uint_eq(fwrite(bytes, 1, n, f), n);
    fclose(f);
}

static inline void same_files(const char *a, const char *b)
{
    lt_file x, y;

    check_ok(lt_file_load(&x, a, LT_FILE_MAX));
    check_ok(lt_file_load(&y, b, LT_FILE_MAX));
    ck_assert_msg(x.n == y.n && memcmp(x.bytes, y.bytes, x.n) == 0, "%s and %s differ", a, b);
    lt_file_free(&x);
    lt_file_free(&y);
}

static inline bool exists(const char *path)
{
    struct stat info;

    return stat(path, &info) == 0;
}

#endif
