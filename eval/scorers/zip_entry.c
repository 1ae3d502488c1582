/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A zip archive of one deflated file. libzip packs from sources that it reads when it closes
 * the archive; here the text is made on the way, once, so zlib and 98 bytes of headers are the
 * shorter road.
 *
 * Source: PKWARE APPNOTE.TXT 6.3.3, sections 4.3.7, 4.3.12 and 4.3.16.
 */
#include "eval/scorers/zip_entry.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/* LEVEL: digits of coordinates hardly pack; zlib's usual 6 takes three times as long for a few percent */
enum { LEVEL = 2, PACKED = 1 << 15, LOCAL = 30, CENTRAL = 46, END = 22, DATE_1980 = 1 << 5 | 1 };

struct zip_entry {
    FILE *f;
    char *name;
    z_stream zlib;
    uint32_t crc;
    uint64_t size, packed;
    unsigned char buffer[PACKED];
};

lt_status zip_entry_new(FILE *f, const char *name, zip_entry **out)
{
    static const unsigned char room[LOCAL] = { 0 };
    zip_entry *z = calloc(1, sizeof(*z));

    if (!z)
        return lt_error(LT_ENOMEM, "%s: no memory to pack it", name);
    z->f = f;
    z->name = strdup(name);
    if (!z->name || deflateInit2(&z->zlib, LEVEL, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY) != Z_OK) {
        free(z->name);
        free(z);
        return lt_error(LT_ENOMEM, "%s: no memory to pack it", name);
    }
    fwrite(room, 1, LOCAL, f);                          /* filled in at the end */
    fwrite(name, 1, strlen(name), f);
    *out = z;
    return LT_OK;
}

static void pack(zip_entry *z, int flush)
{
    size_t made;

    do {
        z->zlib.next_out = z->buffer;
        z->zlib.avail_out = PACKED;
        deflate(&z->zlib, flush);                       /* cannot fail on a sound stream */
        made = PACKED - z->zlib.avail_out;
        fwrite(z->buffer, 1, made, z->f);
        z->packed += made;
    } while (z->zlib.avail_out == 0);
}

void zip_entry_write(zip_entry *z, const void *bytes, size_t n)
{
    const unsigned char *at = bytes;

    while (n > 0) {
        const unsigned part = n < (1u << 30) ? (unsigned)n : 1u << 30;

        z->crc = (uint32_t)crc32(z->crc, at, part);
        z->zlib.next_in = (unsigned char *)(uintptr_t)at;
        z->zlib.avail_in = part;
        pack(z, Z_NO_FLUSH);
        z->size += part;
        at += part;
        n -= part;
    }
}

static unsigned char *put16(unsigned char *p, unsigned v)
{
    p[0] = v & 255;
    p[1] = v >> 8 & 255;
    return p + 2;
}

static unsigned char *put32(unsigned char *p, uint64_t v)
{
    return put16(put16(p, (unsigned)(v & 0xffff)), (unsigned)(v >> 16 & 0xffff));
}

/* What the local and the central header share: version to name length. */
static unsigned char *put_entry(unsigned char *p, const zip_entry *z)
{
    p = put16(p, 20);                                   /* needs version 2.0 */
    p = put16(p, 0);                                    /* flags */
    p = put16(p, 8);                                    /* deflate */
    p = put16(p, 0);                                    /* midnight */
    p = put16(p, DATE_1980);
    p = put32(p, z->crc);
    p = put32(p, z->packed);
    p = put32(p, z->size);
    return put16(p, (unsigned)strlen(z->name));
}

static void write_headers(zip_entry *z)
{
    const size_t name = strlen(z->name);
    const uint64_t directory = LOCAL + name + z->packed;
    unsigned char local[LOCAL] = "PK\3\4", central[CENTRAL] = "PK\1\2", end[END] = "PK\5\6";
    unsigned char *p;

    put_entry(put16(central + 4, 20), z);               /* made by version 2.0; all else 0 */
    fwrite(central, 1, CENTRAL, z->f);
    fwrite(z->name, 1, name, z->f);
    p = put16(put16(end + 8, 1), 1);                    /* entries on this disk, in all */
    put32(put32(p, CENTRAL + name), directory);
    fwrite(end, 1, END, z->f);
    put_entry(local + 4, z);
    fseek(z->f, 0, SEEK_SET);
    fwrite(local, 1, LOCAL, z->f);
}

lt_status zip_entry_finish(zip_entry *z)
{
    lt_status st = LT_OK;

    pack(z, Z_FINISH);
    if (z->size > UINT32_MAX || z->packed > UINT32_MAX - 4096)
        st = lt_error(LT_EINVAL, "%s: %llu bytes, a plain zip entry holds 4 GiB", z->name,
                      (unsigned long long)z->size);
    else
        write_headers(z);
    zip_entry_free(z);
    return st;
}

void zip_entry_free(zip_entry *z)
{
    if (!z)
        return;
    deflateEnd(&z->zlib);
    free(z->name);
    free(z);
}
