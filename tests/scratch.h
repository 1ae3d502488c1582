/* SPDX-License-Identifier: Apache-2.0 */
/* What tests share that write files: a folder and an arena for all of a case, and runs that must end alike. */
#ifndef TESTS_SCRATCH_H
#define TESTS_SCRATCH_H

#include "libtensor/base/arena.h"
#include "tests/suite.h"

static lt_arena *arena;

/* A fixture's two halves. */
static inline void open_scratch(void)
{
    make_scratch_folder();
    arena = lt_arena_new();
    ck_assert_ptr_nonnull(arena);
}

static inline void close_scratch(void)
{
    lt_arena_free(arena);
    remove_scratch_folder();
}

/* A path in the folder, good as long as the arena. */
static inline const char *at(const char *path)
{
    return lt_arena_printf(arena, "%s/%s", scratch_folder, path);
}

/* The last checkpoint of a run in the folder; of two runs that must have come to the same. */
static inline const char *last_of(const char *run)
{
    return at(lt_arena_printf(arena, "%s/checkpoints/last.safetensors", run));
}

static inline void same_end(const char *a, const char *b) { same_files(last_of(a), last_of(b)); }

#endif
