/* SPDX-License-Identifier: Apache-2.0 */
#include "libtensor/base/arena.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { BLOCK_BYTES = 1 << 16, BIG_BYTES = 1 << 14, PAGE = 1 << 12, LAZY_BYTES = 1 << 17, HUGE_PAGE = 1 << 21 };

typedef struct block {
    struct block *next;
    size_t used, size;              /* of the payload, which starts LT_ALIGN bytes in */
} block;

_Static_assert(sizeof(block) <= LT_ALIGN, "a block's header fits before its payload");

struct lt_arena {
    block *blocks;                  /* the first one is filled; the rest are full or of their own */
    block *spare;                   /* of before the last reset, to be used again */
    size_t bytes;
};

static atomic_long fail_countdown;

void lt_alloc_fail_at(long n)
{
    atomic_store(&fail_countdown, n);
}

static bool must_fail(void)
{
    return atomic_load(&fail_countdown) > 0 && atomic_fetch_sub(&fail_countdown, 1) == 1;
}

/* The whole pages within a block */
static void *pages_of(void *memory, size_t bytes, size_t *length)
{
    const uintptr_t from = ((uintptr_t)memory + PAGE - 1) & ~(uintptr_t)(PAGE - 1);
    const uintptr_t to = ((uintptr_t)memory + bytes) & ~(uintptr_t)(PAGE - 1);

    *length = from < to ? to - from : 0;
    return (void *)from;
}

void lt_discard(void *memory, size_t bytes)
{
    size_t length;
    void *pages = pages_of(memory, bytes, &length);

    if (length)
        madvise(pages, length, MADV_DONTNEED);
}

/* Memory of the system is zero until it is written, and takes no place before: what is large is asked for anew
 * instead of cleared. */
static void clear(void *memory, size_t bytes)
{
    size_t length;
    char *pages = pages_of(memory, bytes, &length);

    if (bytes < LAZY_BYTES || madvise(pages, length, MADV_DONTNEED)) {
        memset(memory, 0, bytes);
        return;
    }
    memset(memory, 0, (size_t)(pages - (char *)memory));
    memset(pages + length, 0, (size_t)((char *)memory + bytes - (pages + length)));
}

/* Weights that stream through once miss the TLB at every small page. */
static void *huge_pages(size_t bytes)
{
    void *p;

    if (posix_memalign(&p, HUGE_PAGE, bytes))
        return NULL;
    madvise(p, bytes / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
    return p;
}

void *lt_alloc(size_t bytes)
{
    size_t padded;
    void *p;

    if (!lt_size_add(bytes ? bytes : 1, LT_ALIGN - 1, &padded) || must_fail())
        return NULL;
    padded &= ~(size_t)(LT_ALIGN - 1);
    p = padded < HUGE_PAGE ? aligned_alloc(LT_ALIGN, padded) : huge_pages(padded);
    if (p)
        clear(p, padded);
    return p;
}

void lt_release(void *block_or_null)
{
    free(block_or_null);
}

lt_arena *lt_arena_new(void)
{
    return must_fail() ? NULL : calloc(1, sizeof(lt_arena));
}

/* Gives the blocks of a list back; returns how many bytes they were. */
static size_t release_list(block *b)
{
    size_t bytes = 0;

    for (block *next; b; b = next) {
        next = b->next;
        bytes += LT_ALIGN + b->size;
        lt_release(b);
    }
    return bytes;
}

void lt_arena_free(lt_arena *arena)
{
    if (!arena)
        return;
    release_list(arena->blocks);
    release_list(arena->spare);
    free(arena);
}

void lt_arena_reset(lt_arena *arena)
{
    arena->bytes -= release_list(arena->spare);
    arena->spare = arena->blocks;
    arena->blocks = NULL;
}

/* A spare block that fits without wasting more than half of it, cleared; NULL: there is none. */
static block *take_spare(lt_arena *arena, size_t payload)
{
    for (block **at = &arena->spare, *b; (b = *at); at = &b->next)
        if (b->size >= payload && b->size / 2 <= payload) {
            *at = b->next;
            b->used = 0;
            memset((char *)b + LT_ALIGN, 0, b->size);
            return b;
        }
    return NULL;
}

static block *block_new(lt_arena *arena, size_t payload)
{
    block *b = take_spare(arena, payload);
    size_t bytes;

    if (b || !lt_size_add(payload, LT_ALIGN, &bytes))
        return b;
    b = lt_alloc(bytes);
    if (b) {
        b->size = payload;
        arena->bytes += bytes;
    }
    return b;
}

/* A big request gets a block of its own behind the head, so that the head goes on being filled. */
static void *alloc_big(lt_arena *arena, size_t bytes)
{
    block **at = arena->blocks ? &arena->blocks->next : &arena->blocks;
    block *b = block_new(arena, bytes);

    if (!b)
        return NULL;
    b->used = b->size;
    b->next = *at;
    *at = b;
    return (char *)b + LT_ALIGN;
}

void *lt_arena_alloc(lt_arena *arena, size_t bytes)
{
    block *b = arena->blocks;
    void *p;

    if (bytes > BIG_BYTES)
        return alloc_big(arena, bytes);
    bytes = (bytes + LT_ALIGN - 1) & ~(size_t)(LT_ALIGN - 1);
    if (!b || b->size - b->used < bytes) {
        b = block_new(arena, BLOCK_BYTES);
        if (!b)
            return NULL;
        b->next = arena->blocks;
        arena->blocks = b;
    }
    p = (char *)b + LT_ALIGN + b->used;
    b->used += bytes;
    return p;
}

void *lt_arena_array(lt_arena *arena, size_t count, size_t size)
{
    size_t bytes;

    return lt_size_mul(count, size, &bytes) ? lt_arena_alloc(arena, bytes) : NULL;
}

void *lt_arena_grow(lt_arena *arena, void *list, size_t used, size_t *room, size_t size)
{
    const size_t more = *room ? 2 * *room : 64;
    void *copy;

    if (used < *room)
        return list;
    copy = lt_arena_array(arena, more, size);
    if (!copy)
        return NULL;
    if (used)
        memcpy(copy, list, used * size);
    *room = more;
    return copy;
}

lt_status lt_arena_try(lt_arena *arena, size_t bytes, void **out)
{
    void *p = lt_arena_alloc(arena, bytes);

    if (!p)
        return lt_error(LT_ENOMEM, "no memory for %zu bytes", bytes);
    *out = p;
    return LT_OK;
}

char *lt_arena_strdup(lt_arena *arena, const char *text)
{
    size_t n = strlen(text) + 1;
    char *copy = lt_arena_alloc(arena, n);

    return copy ? memcpy(copy, text, n) : NULL;
}

char *lt_arena_vprintf(lt_arena *arena, const char *fmt, va_list args)
{
    va_list again;
    char *text = NULL;
    int n;

    va_copy(again, args);
    n = vsnprintf(NULL, 0, fmt, again);
    va_end(again);
    if (n >= 0)
        text = lt_arena_alloc(arena, (size_t)n + 1);
    if (text)
        vsnprintf(text, (size_t)n + 1, fmt, args);
    return text;
}

char *lt_arena_printf(lt_arena *arena, const char *fmt, ...)
{
    va_list args;
    char *text;

    va_start(args, fmt);
    text = lt_arena_vprintf(arena, fmt, args);
    va_end(args);
    return text;
}

size_t lt_arena_bytes(const lt_arena *arena)
{
    return arena->bytes;
}
