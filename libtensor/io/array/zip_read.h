/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reading zip archives that nobody vouches for: libzip, with limits that are ours.
 */
#ifndef LT_IO_ARRAY_ZIP_READ_H
#define LT_IO_ARRAY_ZIP_READ_H

#include "libtensor/base/arena.h"
#include "libtensor/base/status.h"

typedef struct {
    const char *name;               /* printable ASCII; lt_path_is_inside */
    size_t bytes;                   /* unpacked; checked against what its packed bytes can hold */
} lt_zip_entry;

typedef struct {
    const char *path;               /* for error lines */
    struct zip *archive;
    size_t n;
    lt_zip_entry *entry;            /* in the archive's order */
} lt_zip;

/* lt_zip_open - the checked list of entries; bytes and arena must outlive it; ends in lt_zip_close */
lt_status lt_zip_open(lt_arena *arena, const char *path, const uint8_t *bytes, size_t n, lt_zip *out);

/* lt_zip_unpack - entry i, all of it, into out (entry[i].bytes of room); verifies its checksum */
lt_status lt_zip_unpack(lt_zip *z, size_t i, uint8_t *out);

/* lt_zip_look - the same, but of what it unpacks only the first n bytes stay, or all where it has fewer */
lt_status lt_zip_look(lt_zip *z, size_t i, uint8_t *out, size_t n);

void lt_zip_close(lt_zip *z);

#endif
