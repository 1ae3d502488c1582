/* SPDX-License-Identifier: Apache-2.0 */
/*
 * replay: every reader meets the seeds, what once broke it (tests/fuzz/corpus/TARGET), and mutations
 * of the seeds, the same ones each time; seeds also while one allocation after the other fails. Needs no fuzzer.
 *   replay seeds DIR     writes the seeds to DIR/TARGET
 *   replay room TARGET   prints how many bytes an input may have
 */
#include "tests/fuzz/fuzz.h"

#include "libtensor/base/rng.h"
#include "libtensor/io/file.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of each seed: how often changed, in up to so many ways at once; how many are refused */
enum { MUTATIONS = 3000, WAYS = 4, ALLOCATIONS = 40 };

static lt_rng rng;
static long n_run;

/* An exact copy, so that a read past the end is seen by a sanitizer. */
static void run(const fuzz_target *t, const uint8_t *bytes, size_t n, long fail_at)
{
    uint8_t *copy = malloc(n ? n : 1);

    if (n)
        memcpy(copy, bytes, n);
    fuzz_run(t, copy, n, fail_at);
    free(copy);
    n_run++;
}

/* Bytes set, bits turned, pieces cut, repeated. */
static size_t mutate_bytes(uint8_t *bytes, size_t n, size_t room)
{
    const size_t at = n ? lt_rng_below(&rng, (uint32_t)n) : 0;
    const size_t piece = n ? 1 + lt_rng_below(&rng, (uint32_t)(n - at)) : 0;

    switch (n ? lt_rng_below(&rng, 5) : 0) {
    case 0:
        if (n < room)
            bytes[n++] = (uint8_t)lt_rng_below(&rng, 256);
        break;
    case 1: bytes[at] ^= (uint8_t)(1u << lt_rng_below(&rng, 8)); break;
    case 2: bytes[at] = (uint8_t)lt_rng_below(&rng, 256); break;
    case 3:
        memmove(bytes + at, bytes + at + piece, n - at - piece);
        n -= piece;
        break;
    default:
        if (n + piece <= room) {
            memmove(bytes + at + piece, bytes + at, n - at);
            n += piece;
        }
    }
    return n;
}

static void run_mutations(const fuzz_target *t, const uint8_t *seed, size_t n)
{
    uint8_t *bytes = malloc(t->max_bytes);

    for (int i = 0; n <= t->max_bytes && i < MUTATIONS; i++) {
        size_t m = n;

        memcpy(bytes, seed, n);
        for (int k = 0; k <= i % WAYS; k++)
            m = t->mutate ? t->mutate(bytes, m, t->max_bytes, lt_rng_below(&rng, UINT32_MAX), mutate_bytes)
                          : mutate_bytes(bytes, m, t->max_bytes);
        run(t, bytes, m, 0);
    }
    free(bytes);
}

/* The first allocation fails, the second, and so on. */
static void run_without_memory(const fuzz_target *t, const uint8_t *bytes, size_t n)
{
    for (long at = 1; at <= ALLOCATIONS; at++)
        run(t, bytes, n, at);
}

static void run_seed(const char *target, const char *name, const uint8_t *bytes, size_t n)
{
    const fuzz_target *t = fuzz_find(target);

    if (!t) {
        fprintf(stderr, "seed %s is for %s, which is no target\n", name, target);
        exit(1);
    }
    rng = lt_rng_make(n, (uint64_t)(t - fuzz_targets));
    run(t, bytes, n, 0);
    run_without_memory(t, bytes, n);
    run_mutations(t, bytes, n);
}

static const char *folder;

static void write_seed(const char *target, const char *name, const uint8_t *bytes, size_t n)
{
    char path[1024];
    FILE *f;

    snprintf(path, sizeof(path), "%s/%s", folder, target);
    if (lt_make_dirs(path))
        exit(1);
    snprintf(path, sizeof(path), "%s/%s/%s", folder, target, name);
    f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, n, f) != n || fclose(f) != 0) {
        perror(path);
        exit(1);
    }
}

/* Past crashes; a target without a folder had none. */
static void run_corpus(const char *corpus, const fuzz_target *t)
{
    char path[1024];
    struct dirent *d;
    DIR *dir;

    snprintf(path, sizeof(path), "%s/%s", corpus, t->name);
    dir = opendir(path);
    while (dir && (d = readdir(dir)) != NULL) {
        lt_arena *arena = lt_arena_new();
        uint8_t *bytes;
        size_t n;

        snprintf(path, sizeof(path), "%s/%s/%s", corpus, t->name, d->d_name);
        if (d->d_name[0] != '.' && lt_read_file(arena, path, LT_FILE_MAX, &bytes, &n) == LT_OK)
            run(t, bytes, n, 0);
        lt_arena_free(arena);
    }
    if (dir)
        closedir(dir);
}

int main(int argc, char **argv)
{
    const char *source = getenv("srcdir");
    char corpus[512];

    if (argc == 3 && strcmp(argv[1], "seeds") == 0) {
        folder = argv[2];
        fuzz_seeds(write_seed);
        return 0;
    }
    if (argc == 3 && strcmp(argv[1], "room") == 0 && fuzz_find(argv[2])) {
        printf("%zu\n", fuzz_find(argv[2])->max_bytes);
        return 0;
    }
    snprintf(corpus, sizeof(corpus), "%s/tests/fuzz/corpus", source ? source : ".");
    for (const fuzz_target *t = fuzz_targets; t->name; t++)
        run_corpus(corpus, t);
    fuzz_seeds(run_seed);
    printf("%ld inputs, none broke a reader\n", n_run);
    return 0;
}
