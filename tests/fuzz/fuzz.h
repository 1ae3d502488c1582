/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Fuzzing of every reader: one table of targets, which libFuzzer drives through libfuzzer.c (scripts/fuzz) and
 * `make check` through replay.c: seeds, past crashes and a fixed number of mutations, with any compiler.
 */
#ifndef TESTS_FUZZ_FUZZ_H
#define TESTS_FUZZ_FUZZ_H

#include "libtensor/base/arena.h"

/* A mutator of bytes without structure: n bytes in place, at most room of them after; the new number. */
typedef size_t fuzz_bytes_fn(uint8_t *bytes, size_t n, size_t room);

/* A mutator that knows the format and leaves the rest to bytes; seed decides. */
typedef size_t fuzz_mutate_fn(uint8_t *bytes, size_t n, size_t room, unsigned seed, fuzz_bytes_fn *mutate_bytes);

typedef void fuzz_put_fn(const char *target, const char *name, const uint8_t *bytes, size_t n);

typedef struct {
    const char *name;
    void (*run)(lt_arena *arena, const uint8_t *bytes, size_t n);   /* read it, look at what came of it */
    fuzz_mutate_fn *mutate;                         /* NULL: bytes without structure */
    size_t max_bytes;                               /* of an input */
} fuzz_target;

/* fuzz_run - a target's run in an arena of its own; fail_at: which allocation from then on fails, 0 none */
void fuzz_run(const fuzz_target *t, const uint8_t *bytes, size_t n, long fail_at);

/* fuzz_targets - ends with a NULL name; fuzz_find - by name, or NULL */
extern const fuzz_target fuzz_targets[];
const fuzz_target *fuzz_find(const char *name);

/* fuzz_seeds - every seed, all of them made by us, to put */
void fuzz_seeds(fuzz_put_fn *put);

/* fuzz_pickle - opcodes removed, repeated, moved, put in between, and their arguments changed */
fuzz_mutate_fn fuzz_pickle;

/* fuzz_zip - one entry's contents changed (as a pickle where its name says so) under a right checksum, or
 * entries dropped and doubled, or the archive's own bytes changed */
fuzz_mutate_fn fuzz_zip;

/* fuzz_png - chunks changed under right checksums */
fuzz_mutate_fn fuzz_png;

/* fuzz_torch - fuzz_zip or fuzz_pickle, whichever fits */
fuzz_mutate_fn fuzz_torch;

#endif
