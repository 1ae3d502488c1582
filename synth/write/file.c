/* SPDX-License-Identifier: Apache-2.0 */
#include "synth/write/file.h"

#include "libtensor/io/file.h"

#include <stdio.h>
#include <zlib.h>

lt_status synth_describe_file(const char *root, const char *path, synth_file *out)
{
    lt_arena *arena = lt_arena_new();
    const char *full = arena ? lt_path_join(arena, root, path) : NULL;
    uint8_t *bytes;
    size_t n;
    lt_status st = full ? lt_read_file(arena, full, LT_FILE_MAX, &bytes, &n)
                        : lt_error(LT_ENOMEM, "%s: no memory", path);

    if (!st) {
        snprintf(out->path, sizeof(out->path), "%s", path);
        out->crc = (uint32_t)crc32_z(0, bytes, n);
    }
    lt_arena_free(arena);
    return st;
}
