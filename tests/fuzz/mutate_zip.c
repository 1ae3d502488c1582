/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Mutation of zip archives: unpacked, an entry changed, and packed again, so that what is behind a checksum is
 * reached. And of checkpoints, whose container decides.
 */
#include "tests/fuzz/fuzz.h"

#include "libtensor/io/array/zip_read.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { ENTRIES_MAX = 32, LOCAL = 30, CENTRAL = 46, END = 22 };

typedef struct {
    const char *name;
    uint8_t *bytes;
    size_t n;
} entry;

typedef struct {
    entry entry[ENTRIES_MAX];
    size_t n, bytes;                    /* entries; of all contents */
} archive;

static void put(uint8_t **p, uint64_t x, int bytes)
{
    for (int i = 0; i < bytes; i++)
        *(*p)++ = (uint8_t)(i < 8 ? x >> (8 * i) : 0);
}

/* What local and central headers share, from the version on. */
static void put_common(uint8_t **p, const entry *e)
{
    put(p, 20, 2);
    put(p, 0, 2 + 2 + 2);                               /* flags, stored, midnight */
    put(p, 33, 2);                                      /* 1980-01-01 */
    put(p, crc32(0, e->bytes, (uInt)e->n), 4);
    put(p, e->n, 4);
    put(p, e->n, 4);
    put(p, strlen(e->name), 2);
    put(p, 0, 2);
}

/* A stored archive; 0 when it has no room. */
static size_t pack(const archive *a, uint8_t *out, size_t room)
{
    size_t need = END + a->bytes, offset[ENTRIES_MAX], begin, names = 0;
    uint8_t *p = out;

    for (size_t i = 0; i < a->n; i++)
        names += strlen(a->entry[i].name);
    need += 2 * names + a->n * (LOCAL + CENTRAL);
    if (need > room)
        return 0;
    for (size_t i = 0; i < a->n; i++) {
        offset[i] = (size_t)(p - out);
        put(&p, 0x04034b50, 4);
        put_common(&p, &a->entry[i]);
        memcpy(p, a->entry[i].name, strlen(a->entry[i].name));
        p += strlen(a->entry[i].name);
        if (a->entry[i].n)
            memcpy(p, a->entry[i].bytes, a->entry[i].n);
        p += a->entry[i].n;
    }
    begin = (size_t)(p - out);
    for (size_t i = 0; i < a->n; i++) {
        put(&p, 0x02014b50, 4);
        put(&p, 20, 2);
        put_common(&p, &a->entry[i]);
        put(&p, 0, 2 + 2 + 2 + 4);
        put(&p, offset[i], 4);
        memcpy(p, a->entry[i].name, strlen(a->entry[i].name));
        p += strlen(a->entry[i].name);
    }
    put(&p, 0x06054b50, 4);
    put(&p, 0, 4);
    put(&p, a->n, 2);
    put(&p, a->n, 2);
    put(&p, (uint64_t)(p - out) - 12 - begin, 4);
    put(&p, begin, 4);
    put(&p, 0, 2);
    return (size_t)(p - out);
}

static bool unpack(lt_arena *arena, const uint8_t *bytes, size_t n, size_t room, archive *out)
{
    lt_zip z;
    bool good = true;

    if (lt_zip_open(arena, "x.zip", bytes, n, &z) != LT_OK)
        return false;
    for (size_t i = 0; good && i < z.n && i < ENTRIES_MAX; i++) {
        entry *e = &out->entry[i];

        e->name = z.entry[i].name;
        e->n = z.entry[i].bytes;
        good = e->n <= room && (e->bytes = lt_arena_alloc(arena, room)) && lt_zip_unpack(&z, i, e->bytes) == LT_OK;
        out->bytes += e->n;
        out->n++;
    }
    lt_zip_close(&z);
    return good && out->n > 0;
}

static bool is_pickle(const entry *e)
{
    const size_t n = strlen(e->name);

    return n > 4 && strcmp(e->name + n - 4, ".pkl") == 0;
}

static void change(archive *a, size_t room, unsigned seed, fuzz_bytes_fn *mutate_bytes)
{
    size_t i = (seed >> 4) % a->n;
    entry *e;

    for (size_t k = 0; k < a->n && seed & 8; k++)       /* half of the time the pickle, where there is one */
        i = is_pickle(&a->entry[k]) ? k : i;
    e = &a->entry[i];
    a->bytes -= e->n;
    if (seed % 16 == 5) {
        *e = a->entry[--a->n];
        return;
    }
    e->n = is_pickle(e) ? fuzz_pickle(e->bytes, e->n, room, seed, mutate_bytes) : mutate_bytes(e->bytes, e->n, room);
    a->bytes += e->n;
}

size_t fuzz_zip(uint8_t *bytes, size_t n, size_t room, unsigned seed, fuzz_bytes_fn *mutate_bytes)
{
    lt_arena *arena = lt_arena_new();
    archive a = { .n = 0 };
    size_t packed = 0;

    if (seed % 4 && unpack(arena, bytes, n, room, &a)) {
        change(&a, room, seed / 4, mutate_bytes);
        packed = pack(&a, bytes, room);
    }
    lt_arena_free(arena);
    return packed ? packed : mutate_bytes(bytes, n, room);
}

size_t fuzz_torch(uint8_t *bytes, size_t n, size_t room, unsigned seed, fuzz_bytes_fn *mutate_bytes)
{
    const bool zip = n >= 4 && memcmp(bytes, "PK\3\4", 4) == 0;

    return (zip ? fuzz_zip : fuzz_pickle)(bytes, n, room, seed, mutate_bytes);
}
