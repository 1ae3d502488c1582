/* SPDX-License-Identifier: Apache-2.0 */
/* Mutation of PNG files: chunks changed, dropped and doubled, each under a right length and checksum. */
#include "tests/fuzz/fuzz.h"

#include <string.h>
#include <zlib.h>

enum { MAGIC = 8, HEAD = 8, CRC = 4, CHUNKS_MAX = 64 };

typedef struct {
    uint8_t *bytes;
    size_t n, room;
    size_t start[CHUNKS_MAX + 1], chunks;
} png;

static uint32_t big_endian(const uint8_t *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

static void put(uint8_t *p, uint32_t x)
{
    for (int i = 0; i < 4; i++)
        p[i] = (uint8_t)(x >> (24 - 8 * i));
}

static void find_chunks(png *f)
{
    size_t at = MAGIC;

    for (f->chunks = 0; f->chunks < CHUNKS_MAX && f->n >= at + HEAD + CRC; f->chunks++) {
        const uint32_t length = big_endian(f->bytes + at);

        f->start[f->chunks] = at;
        if (length > f->n - at - HEAD - CRC)
            break;
        at += HEAD + length + CRC;
    }
    f->start[f->chunks] = at;
}

static void replace(png *f, size_t at, size_t gone, const uint8_t *with, size_t n)
{
    if (f->n - gone + n > f->room)
        return;
    memmove(f->bytes + at + n, f->bytes + at + gone, f->n - at - gone);
    if (n)
        memcpy(f->bytes + at, with, n);
    f->n = f->n - gone + n;
}

static void change_data(png *f, size_t i, fuzz_bytes_fn *mutate_bytes)
{
    const size_t at = f->start[i], n = f->start[i + 1] - at - HEAD - CRC;
    uint8_t chunk[HEAD + 1024 + CRC];
    size_t m = n < 1024 ? n : 1024;

    memcpy(chunk, f->bytes + at, HEAD + m);
    m = mutate_bytes(chunk + HEAD, m, 1024);
    put(chunk, (uint32_t)m);
    put(chunk + HEAD + m, (uint32_t)crc32(0, chunk + 4, (uInt)(4 + m)));
    replace(f, at, n + HEAD + CRC, chunk, HEAD + m + CRC);
}

static void twice(png *f, size_t i)
{
    uint8_t chunk[2048];
    const size_t n = f->start[i + 1] - f->start[i];

    if (n > sizeof(chunk))
        return;
    memcpy(chunk, f->bytes + f->start[i], n);
    replace(f, f->start[i], 0, chunk, n);
}

size_t fuzz_png(uint8_t *bytes, size_t n, size_t room, unsigned seed, fuzz_bytes_fn *mutate_bytes)
{
    png f = { .bytes = bytes, .n = n, .room = room };
    size_t i;

    find_chunks(&f);
    if (f.chunks == 0 || seed % 8 == 0)
        return mutate_bytes(bytes, n, room);
    i = seed / 8 % f.chunks;
    switch (seed / 512 % 8) {
    case 0: replace(&f, f.start[i], f.start[i + 1] - f.start[i], NULL, 0); break;
    case 1: twice(&f, i); break;
    default: change_data(&f, i, mutate_bytes); break;
    }
    return f.n;
}
