/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Memory by lifetime: a graph, a plan, a module each own one arena, freed as a whole.
 */
#ifndef LT_BASE_ARENA_H
#define LT_BASE_ARENA_H

#include "libtensor/base/common.h"
#include "libtensor/base/status.h"

#include <stdarg.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct lt_arena lt_arena;

/* lt_arena_new - an empty arena, or NULL when there is no memory; lt_arena_free(NULL) is fine */
LT_API lt_arena *lt_arena_new(void);
LT_API void lt_arena_free(lt_arena *arena);

/* lt_arena_reset - empty it, for the next of many alike pieces of work: what it held is gone, but the memory stays
 * for what is asked of it next. What two resets in a row find unused goes back to the system. */
LT_API void lt_arena_reset(lt_arena *arena);

/**
 * lt_arena_alloc - zeroed memory aligned to LT_ALIGN, living as long as the arena
 *
 * Returns NULL when there is no memory. Zero bytes give a valid pointer.
 */
LT_API void *lt_arena_alloc(lt_arena *arena, size_t bytes);

/* lt_arena_array - lt_arena_alloc of count * size bytes; NULL also when that product overflows */
LT_API void *lt_arena_array(lt_arena *arena, size_t count, size_t size);

/*
 * lt_arena_grow - a list that is added to: list itself, or when all *room are used a copy with twice the room
 *   list, room      NULL and 0 to begin with
 *   The copies left behind stay in the arena, together no more than the list. NULL when there is no memory.
 */
LT_API void *lt_arena_grow(lt_arena *arena, void *list, size_t used, size_t *room, size_t size);

/* lt_arena_try - as lt_arena_alloc for amounts that a file asks for: LT_ENOMEM and a line when refused */
LT_API lt_status lt_arena_try(lt_arena *arena, size_t bytes, void **out);

/* lt_arena_strdup, lt_arena_printf, lt_arena_vprintf - text in the arena; NULL when there is no memory */
LT_API char *lt_arena_strdup(lt_arena *arena, const char *text);
LT_API char *lt_arena_printf(lt_arena *arena, const char *fmt, ...) LT_PRINTF(2, 3);
LT_API char *lt_arena_vprintf(lt_arena *arena, const char *fmt, va_list args) LT_PRINTF(2, 0);

/* lt_arena_bytes - what the arena holds, blocks and all */
LT_API size_t lt_arena_bytes(const lt_arena *arena);

/* lt_alloc, lt_release - one aligned, zeroed block outside any arena; NULL when there is no memory */
LT_API void *lt_alloc(size_t bytes);
LT_API void lt_release(void *block);

/* lt_discard - give memory back while it stays allocated: its whole pages hold zeros from now on, and take no
 * place until they are written */
LT_API void lt_discard(void *memory, size_t bytes);

/**
 * lt_alloc_fail_at - make the n-th block asked of the system from now on fail, once (0: never)
 *
 * For tests of what happens without memory; counts lt_alloc and the blocks of all arenas.
 */
LT_API void lt_alloc_fail_at(long n);

#ifdef __cplusplus
}
#endif
#endif
