/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What every reader must stand: its samples cut at every byte, and with bits flipped. Run under the
 * address sanitizer; each attempt reads from a block of exactly its size.
 */
#ifndef TESTS_IO_HOSTILE_H
#define TESTS_IO_HOSTILE_H

#include "libtensor/base/arena.h"
#include "libtensor/base/rng.h"
#include "tests/suite.h"

typedef lt_status reader(lt_arena *arena, const uint8_t *bytes, size_t n);

/* Read a private copy; a refusal must have come with one line. */
static inline lt_status attempt(reader *read, const uint8_t *bytes, size_t n)
{
    lt_arena *arena = lt_arena_new();
    uint8_t *copy = malloc(n ? n : 1);
    lt_status st;

    if (n)
        memcpy(copy, bytes, n);
    lt_error(LT_OK, "nothing was said");
    st = read(arena, copy, n);
    if (st) {
        ck_assert_str_ne(lt_last_error(), "nothing was said");
        ck_assert_ptr_nonnull(strchr(lt_last_error(), ':'));
        ck_assert_ptr_null(strchr(lt_last_error(), '\n'));
    }
    free(copy);
    lt_arena_free(arena);
    return st;
}

/* spare: how many bytes at the end may be missing unnoticed. */
static inline void check_truncated(reader *read, const uint8_t *bytes, size_t n, size_t spare)
{
    ck_assert_msg(attempt(read, bytes, n) == LT_OK, "whole: %s", lt_last_error());
    for (size_t cut = 0; cut + spare < n; cut++)
        ck_assert_msg(attempt(read, bytes, cut) != LT_OK, "cut to %zu of %zu bytes", cut, n);
}

/* One to four bits at a time: whatever comes of it, no crash. */
static inline void check_flipped(reader *read, const uint8_t *bytes, size_t n, int tries)
{
    lt_rng rng = lt_rng_make(20, n);
    uint8_t *copy = malloc(n);

    for (int t = 0; t < tries; t++) {
        memcpy(copy, bytes, n);
        for (uint32_t k = 1 + lt_rng_below(&rng, 4); k > 0; k--)
            copy[lt_rng_below(&rng, (uint32_t)n)] ^= (uint8_t)(1u << lt_rng_below(&rng, 8));
        attempt(read, copy, n);
    }
    free(copy);
}

/* An arena with room for so many pieces of up to LT_ALIGN bytes before it asks the system again, which lt_alloc_fail_at
 * then refuses. */
static inline lt_arena *arena_with_room(int pieces)
{
    static int all;
    lt_arena *arena = lt_arena_new();

    if (!all) {
        lt_arena *full = lt_arena_new();

        lt_arena_alloc(full, 1);
        for (const size_t block = lt_arena_bytes(full); lt_arena_bytes(full) == block; all++)
            lt_arena_alloc(full, 1);
        lt_arena_free(full);
    }
    for (int i = pieces; i < all; i++)
        lt_arena_alloc(arena, 1);
    return arena;
}

/* Whatever part of its memory is refused, a reader says so and nothing else. Returns how often it was. */
static inline int check_without_memory(reader *read, const uint8_t *bytes, size_t n)
{
    enum { ROOMS = 100 };
    int refused = 0;

    for (int room = 0; room < ROOMS; room++) {
        lt_status st = LT_ENOMEM;

        for (long at = 1; st; at++) {
            lt_arena *arena = arena_with_room(room);

            lt_alloc_fail_at(at);
            st = read(arena, bytes, n);
            lt_alloc_fail_at(0);
            ck_assert_msg(st == LT_OK || st == LT_ENOMEM, "room %d, block %ld: %s", room, at, lt_last_error());
            refused += st == LT_ENOMEM;
            lt_arena_free(arena);
        }
    }
    return refused;
}

static inline void check_refused(reader *read, const void *bytes, size_t n, const char *reason)
{
    ck_assert(attempt(read, bytes, n) != LT_OK);
    ck_assert_msg(strstr(lt_last_error(), reason), "\"%s\" lacks \"%s\"", lt_last_error(), reason);
}

#endif
